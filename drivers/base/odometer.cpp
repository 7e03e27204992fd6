// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/odometer.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace arpent::base {
namespace {

/// A difference may be this many times what the greatest speed allows: readings come at uneven times.
constexpr double kTolerance = 2.0;
constexpr double kLeastIntervalS = 0.02;
/// So slow a command may well not move the wheel.
constexpr double kNoticeableMps = 0.1;
/// A wheel moves by less than this share of its command: stuck.
constexpr double kStuckShare = 0.1;
/// Over so long ways are compared: lag is a small part of it, and single counts do not matter.
constexpr double kWindowS = 0.5;
constexpr double kRounding = 1e-9;

}  // namespace

OdometerFault Odometer::update(std::int32_t count, double commanded_mps, Time now) {
  const std::optional<std::int32_t> before = last_;
  const double interval_s = std::max(to_seconds(now - last_at_), kLeastIntervalS);
  last_ = count;
  last_at_ = now;
  if (!before) return OdometerFault::kNone;
  // In unsigned arithmetic a counter that wraps differs by what it moved.
  const auto counts =
      static_cast<std::int32_t>(static_cast<std::uint32_t>(count) - static_cast<std::uint32_t>(*before));
  const double moved_m = unit_m_ * counts;
  const double most_m = kTolerance * max_speed_mps_ * interval_s + unit_m_;
  if (std::abs(moved_m) > most_m) {
    return std::abs(unit_m_ * count) <= most_m ? OdometerFault::kReset : OdometerFault::kJump;
  }
  way_m_ += moved_m;
  return compare_with_command(moved_m, interval_s, commanded_mps);
}

OdometerFault Odometer::compare_with_command(double moved_m, double interval_s, double commanded_mps) {
  const double told_m = commanded_mps * interval_s;
  if (std::abs(commanded_mps) < kNoticeableMps || told_m * sum_.told_m < 0) {
    window_.clear();
    sum_ = {};
    return OdometerFault::kNone;
  }
  const auto add = [this](const Step& step, double sign) {
    sum_.interval_s += sign * step.interval_s;
    sum_.told_m += sign * step.told_m;
    sum_.moved_m += sign * step.moved_m;
  };
  window_.push_back({interval_s, told_m, moved_m});
  add(window_.back(), 1);
  while (sum_.interval_s - window_.front().interval_s >= kWindowS - kRounding) {
    add(window_.front(), -1);
    window_.pop_front();
  }
  const double share = sum_.moved_m / sum_.told_m;
  if (sum_.interval_s < kWindowS - kRounding || share > kStuckShare) return OdometerFault::kNone;
  return share < -kStuckShare ? OdometerFault::kReversed : OdometerFault::kStuck;
}

}  // namespace arpent::base
