// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/motion_hint.h"

#include <gtest/gtest.h>

#include <cmath>

namespace arpent::odometry {
namespace {

using std::chrono::milliseconds;

constexpr double kRate = 0.8, kSpeed = 0.5;

Time at(int ms) {
  return Time(std::chrono::seconds(1000)) + milliseconds(ms);
}

/// An even arc, read every 20 ms.
MotionHint make_arc(int until_ms, bool wheels = true) {
  MotionHint hint;
  for (int ms = 0; ms <= until_ms; ms += 20) {
    hint.add_turn_rate(at(ms), kRate);
    if (wheels) hint.add_way(at(ms), 7 + kSpeed * ms / 1000.0);
  }
  return hint;
}

void expect_arc(const std::optional<Pose>& step, double duration_s) {
  ASSERT_TRUE(step);
  const double turn = kRate * duration_s, radius = kSpeed / kRate;
  EXPECT_NEAR(so3_log(step->linear()).z(), turn, 1e-9);
  // The chord stands for the arc.
  EXPECT_NEAR(step->translation().x(), radius * std::sin(turn), 1e-3);
  EXPECT_NEAR(step->translation().y(), radius * (1 - std::cos(turn)), 1e-3);
}

TEST(MotionHint, AnArcIsFoundStepByStepAlsoBetweenReadings) {
  MotionHint hint = make_arc(1000);
  expect_arc(hint.step(at(100), at(300), 0), 0.2);
  expect_arc(hint.step(at(300), at(507), 0), 0.207);
  expect_arc(hint.step(at(507), at(705), 0), 0.198);
}

TEST(MotionHint, ReadingsOfTheLastMomentChangeNothing) {
  MotionHint early = make_arc(260), late = make_arc(260);
  late.add_turn_rate(at(280), -3);
  late.add_way(at(280), 99);
  const auto a = early.step(at(100), at(300), 0), b = late.step(at(100), at(300), 0);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->matrix(), b->matrix());
  expect_arc(a, 0.2);
}

TEST(MotionHint, WithoutWheelsTheLastSpeedGoesOnAndWithoutGyroNothingIsSaid) {
  expect_arc(make_arc(300, false).step(at(100), at(300), kSpeed), 0.2);
  EXPECT_FALSE(make_arc(100).step(at(100), at(300), kSpeed)) << "the gyro has fallen silent";
  EXPECT_FALSE(MotionHint().step(at(100), at(300), kSpeed));
}

TEST(MotionHint, ASecondLookAtTheSameTimeIsNoStep) {
  MotionHint hint = make_arc(1000);
  (void)hint.step(at(100), at(300), 0);
  const auto none = hint.step(at(300), at(300), 0);
  ASSERT_TRUE(none);
  EXPECT_NEAR(none->translation().norm(), 0, 1e-9);
}

}  // namespace
}  // namespace arpent::odometry
