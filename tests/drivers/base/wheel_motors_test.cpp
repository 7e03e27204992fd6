// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wheel_motors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/error.h"

namespace arpent::base {
namespace {

constexpr double kStepS = 0.005;

void run(WheelMotors& motors, const Twist2& wanted, double duration_s) {
  for (int i = 0; i < std::lround(duration_s / kStepS); ++i) motors.step(wanted, kStepS);
}

TEST(WheelMotors, TheyFollowWithTheirLag) {
  MotorParams params;
  params.max_acceleration_mps2 = 1000;
  WheelMotors motors(params);
  run(motors, {0.5, 0}, params.lag_s);
  EXPECT_NEAR(motors.ground_twist().speed_mps, 0.5 * (1 - std::exp(-1.0)), 1e-9);
}

TEST(WheelMotors, TheyAccelerateNoFasterThanTheyCan) {
  MotorParams params;
  params.lag_s = 0;
  params.max_acceleration_mps2 = 1.5;
  WheelMotors motors(params);
  run(motors, {1.0, 0}, 0.4);
  EXPECT_NEAR(motors.ground_twist().speed_mps, 0.6, 1e-9);
}

TEST(WheelMotors, SlipOnOneSideTurnsTheBaseAndTheEncodersDoNotSeeIt) {
  MotorParams params;
  params.left_slip = 0.1;
  WheelMotors motors(params);
  run(motors, {0.5, 0}, 2);
  EXPECT_NEAR(motors.ground_twist().speed_mps, 0.475, 1e-6);
  // The right side is 0.05 m/s faster over ground, 0.583 m away.
  EXPECT_NEAR(motors.ground_twist().turn_rate_radps, 0.05 / 0.583, 1e-6);
  EXPECT_NEAR(motors.wheel_twist().turn_rate_radps, 0, 1e-12);
  EXPECT_EQ(motors.count(Side::kLeft), motors.count(Side::kRight));
}

TEST(WheelMotors, CountersAreWholeAndWrapAtThirtyTwoBits) {
  MotorParams params;
  params.counts_per_m = 5312;
  WheelMotors motors(params);
  run(motors, {0.5, 0}, 1);
  const std::int32_t way = motors.count(Side::kLeft);
  EXPECT_GT(way, 1900);
  EXPECT_LT(way, 2656);
  motors.set_count(Side::kLeft, std::numeric_limits<std::int32_t>::max() - 10);
  run(motors, {0.5, 0}, 1);
  EXPECT_LT(motors.count(Side::kLeft), 0);
  motors.restart();
  run(motors, {-0.5, 0}, 0.02);
  EXPECT_LT(motors.count(Side::kRight), 0);
}

TEST(WheelMotors, AgainstAnObstacleTheWheelsStallAndShowWhereTheyStrive) {
  WheelMotors motors({});
  run(motors, {0.5, 0}, 1);
  motors.set_blocked(true);
  run(motors, {0.5, 0}, 0.1);
  EXPECT_NEAR(motors.ground_twist().speed_mps, 0.025, 1e-9);
  run(motors, {-0.5, 0}, 0.1);
  EXPECT_LT(motors.ground_twist().speed_mps, 0) << "it wants to back out";
  motors.set_blocked(false);
  run(motors, {-0.5, 0}, 2);
  EXPECT_NEAR(motors.ground_twist().speed_mps, -0.5, 1e-3);
}

TEST(WheelMotors, EncoderFaultsChangeCountersNotMotion) {
  for (const auto& [fault, gain] :
       {std::pair{EncoderFault::kStuck, 0.0}, {EncoderFault::kReversed, -1.0}, {EncoderFault::kDoubled, 2.0}}) {
    WheelMotors motors({});
    motors.set_encoder_fault(Side::kRight, fault);
    run(motors, {0.5, 0}, 2);
    EXPECT_NEAR(motors.count(Side::kRight), gain * motors.count(Side::kLeft), 2);
    EXPECT_NEAR(motors.ground_twist().turn_rate_radps, 0, 1e-12);
  }
}

TEST(WheelMotors, ImpossibleParametersAreRefused) {
  MotorParams params;
  params.geometry.track_m = -0.4;
  EXPECT_THROW(WheelMotors{params}, InputError);
}

}  // namespace
}  // namespace arpent::base
