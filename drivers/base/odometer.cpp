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
/// Lag and slip are allowed for so long.
constexpr Duration kPatience{700000};

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
  return compare_with_command(moved_m / interval_s, commanded_mps, now);
}

OdometerFault Odometer::compare_with_command(double speed_mps, double commanded_mps, Time now) {
  const double along = std::copysign(1.0, commanded_mps) * speed_mps;
  if (std::abs(commanded_mps) < kNoticeableMps || along > kStuckShare * std::abs(commanded_mps)) {
    disagrees_since_.reset();
    return OdometerFault::kNone;
  }
  if (!disagrees_since_) disagrees_since_ = now;
  if (now - *disagrees_since_ < kPatience) return OdometerFault::kNone;
  return along < -kStuckShare * std::abs(commanded_mps) ? OdometerFault::kReversed : OdometerFault::kStuck;
}

}  // namespace arpent::base
