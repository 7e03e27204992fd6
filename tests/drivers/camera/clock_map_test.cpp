// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/clock_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace arpent::camera {
namespace {

/// A device whose clock is `offset` behind ours and drifts; frames arrive after an exponential delay.
struct Device {
  Duration offset{123'456'789};
  double drift = 0;
  double mean_delay_us = 4000;
  std::mt19937 random{11};

  Time truth(Time device) const {
    return device + offset + Duration(std::llround(drift * double(device.time_since_epoch().count())));
  }
  Time arrival(Time device) {
    return truth(device) + Duration(std::llround(std::exponential_distribution<double>(1 / mean_delay_us)(random)));
  }
};

TEST(CameraClockMap, OneSampleGivesItsOwnOffset) {
  ClockMap map;
  map.add(Time(Duration(1000)), Time(Duration(51000)));
  EXPECT_EQ(map.to_host(Time(Duration(2000))), Time(Duration(52000)));
}

TEST(CameraClockMap, ArrivalJitterHardlyReachesTheResultAndNeverMakesItEarly) {
  for (const double drift : {0.0, 100e-6, -100e-6}) {
    Device device;
    device.drift = drift;
    ClockMap map;
    double worst_us = 0;
    for (int i = 0; i < 400; ++i) {
      const Time t(Duration(200'000LL * i));
      map.add(t, device.arrival(t));
      if (i >= 100) worst_us = std::max(worst_us, std::abs(double((map.to_host(t) - device.truth(t)).count())));
    }
    // Of 100 delays with mean 4 ms the least is 40 us on average; two such points carry the line.
    EXPECT_LT(worst_us, 1000) << "drift " << drift;
  }
}

TEST(CameraClockMap, LateSamplesAreNotPromptAndAnEarlierOneShowsThatTheOthersWereLate) {
  ClockMap map;
  EXPECT_EQ(map.prompt(Duration(1000)), 0U);
  for (int i = 0; i < 5; ++i) map.add(Time(Duration(200'000LL * i)), Time(Duration(200'000LL * i + 50'000 + 100 * i)));
  EXPECT_EQ(map.prompt(Duration(1000)), 5U);
  map.add(Time(Duration(1'000'000)), Time(Duration(1'000'000 + 20'000)));
  EXPECT_EQ(map.prompt(Duration(1000)), 1U);
  EXPECT_EQ(map.prompt(Duration(60'000)), 6U);
}

TEST(CameraClockMap, IsTheHighestLineBelowAllSamplesAsBruteForceFindsIt) {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> delay(0, 3000);
  for (int trial = 0; trial < 20; ++trial) {
    ClockMap map;
    std::vector<std::pair<double, double>> points;  // device [us], delay [us]
    for (int i = 0; i < 30; ++i) {
      // A long span, so that lines through pairs of samples stay within the bound on the drift.
      const std::int64_t t = 1'000'000LL * i;
      points.emplace_back(double(t), delay(random) % 300);
      map.add(Time(Duration(t)), Time(Duration(t + std::int64_t(points.back().second))));
    }
    const double mean_us = 14.5e6;
    double best_height = -std::numeric_limits<double>::infinity();
    for (const auto& a : points) {
      for (const auto& b : points) {
        if (a.first >= b.first) continue;
        const double slope = (b.second - a.second) / (b.first - a.first);
        const double at_zero = a.second - slope * a.first;
        const bool below = std::all_of(points.begin(), points.end(),
                                       [&](const auto& p) { return at_zero + slope * p.first <= p.second + 1e-6; });
        if (below) best_height = std::max(best_height, at_zero + slope * mean_us);
      }
    }
    const double height = double((map.to_host(Time(Duration(14'500'000))) - Time(Duration(14'500'000))).count());
    EXPECT_NEAR(height, best_height, 1.0) << "trial " << trial;
  }
}

TEST(CameraClockMap, ForgetsWhatLiesBeforeItsWindow) {
  ClockMap map(10);
  map.add(Time(Duration(0)), Time(Duration(-5000)));  // a stale, impossible sample
  for (int i = 1; i <= 10; ++i) map.add(Time(Duration(1000 * i)), Time(Duration(1000 * i + 70)));
  EXPECT_EQ(map.to_host(Time(Duration(10000))), Time(Duration(10070)));
  EXPECT_EQ(map.size(), 10U);
}

}  // namespace
}  // namespace arpent::camera
