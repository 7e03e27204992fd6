// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/clock_map.h"

#include <algorithm>

#include "common/error.h"

namespace arpent::camera {
namespace {

/// No crystal is worse than this.
constexpr double kMostDrift = 300e-6;
constexpr int kSearchSteps = 40;

double us(Duration duration) {
  return static_cast<double>(duration.count());
}

}  // namespace

void ClockMap::add(Time device, Time earliest) {
  samples_.push_back({device, earliest - device});
  if (samples_.size() > window_) samples_.pop_front();
  fit();
}

void ClockMap::fit() {
  const Sample& first = samples_.front();
  double mean_us = 0;
  for (const Sample& s : samples_) mean_us += us(s.device - first.device) / static_cast<double>(samples_.size());
  const auto intercept = [&](double rate) {
    double least = us(samples_.front().delay - first.delay);
    for (const Sample& s : samples_)
      least = std::min(least, us(s.delay - first.delay) - rate * us(s.device - first.device));
    return least;
  };
  // The line's height at the mean is a concave function of its slope: golden-section search would save little here.
  const auto height = [&](double rate) { return intercept(rate) + rate * mean_us; };
  double low = -kMostDrift;
  double high = kMostDrift;
  for (int i = 0; i < kSearchSteps; ++i) {
    const double a = low + (high - low) / 3;
    const double b = high - (high - low) / 3;
    (height(a) < height(b) ? low : high) = height(a) < height(b) ? a : b;
  }
  rate_ = (low + high) / 2;
  offset_us_ = intercept(rate_);
}

std::size_t ClockMap::prompt(Duration within) const {
  if (samples_.empty()) return 0;
  const Sample& first = samples_.front();
  return static_cast<std::size_t>(std::ranges::count_if(samples_, [&](const Sample& s) {
    return us(s.delay - first.delay) - offset_us_ - rate_ * us(s.device - first.device) <= us(within);
  }));
}

Time ClockMap::to_host(Time device) const {
  ARPENT_ASSERT(!samples_.empty());
  const Sample& first = samples_.front();
  const double beyond_us = offset_us_ + rate_ * us(device - first.device);
  return device + first.delay + from_seconds(beyond_us * 1e-6);
}

}  // namespace arpent::camera
