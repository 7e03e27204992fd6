// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "sim/robot/sim_imu.h"
#include "sim/robot/sim_odometry.h"
#include "sim/robot/sim_robot.h"

namespace arpent::sim {
namespace {

TEST(SimRobot, AnArcEndsWhereManyShortStraightStepsEnd) {
  const Twist2 twist{0.5, -0.8};
  Pose2 stepped{1, 2, 0.3};
  constexpr int kSteps = 200000;
  for (int i = 0; i < kSteps; ++i) {
    const double dt = 3.0 / kSteps;
    stepped = {stepped.x_m + twist.speed_mps * dt * std::cos(stepped.yaw_rad),
               stepped.y_m + twist.speed_mps * dt * std::sin(stepped.yaw_rad),
               stepped.yaw_rad + twist.turn_rate_radps * dt};
  }
  const Pose2 arc = move_along_arc({1, 2, 0.3}, twist, 3.0);
  EXPECT_NEAR(arc.x_m, stepped.x_m, 1e-5);
  EXPECT_NEAR(arc.y_m, stepped.y_m, 1e-5);
  EXPECT_NEAR(wrap_angle(arc.yaw_rad - stepped.yaw_rad), 0, 1e-9);
}

TEST(SimRobot, StandsAtAWallAndCountsEachContactOnce) {
  SimRobot robot({0, 0, 0}, [](const Pose2& pose) { return pose.x_m > 1; });
  for (int i = 0; i < 300; ++i) robot.step({0.5, 0}, 0.01);
  EXPECT_NEAR(robot.pose().x_m, 1, 0.0051);
  EXPECT_TRUE(robot.in_contact());
  EXPECT_EQ(robot.collisions(), 1);
  EXPECT_EQ(robot.twist(), Twist2{});
  for (int i = 0; i < 10; ++i) robot.step({0, 0}, 0.01);
  EXPECT_EQ(robot.collisions(), 1) << "waiting at the wall is no new contact";
  for (int i = 0; i < 100; ++i) robot.step({-0.5, 0}, 0.01);
  EXPECT_FALSE(robot.in_contact());
  for (int i = 0; i < 300; ++i) robot.step({0.5, 0}, 0.01);
  EXPECT_EQ(robot.collisions(), 2);
}

TEST(SimImu, MeanAndDeviationAreThoseOfItsNoise) {
  constexpr double kDt = 0.01;
  constexpr int kCount = 20000;
  ImuNoise noise;
  noise.gyro_bias_radps = noise.accelerometer_bias_mps2 = noise.gyro_walk_radps2rthz = 0;
  SimImu imu(noise, 5);
  double sum = 0, squares = 0, forward = 0, sideways = 0, up = 0;
  for (int i = 0; i < kCount; ++i) {
    const ImuReading r = imu.read({0.5, 0.8}, kDt);
    const double e = r.angular_velocity_radps.z() - 0.8;
    sum += e;
    squares += e * e;
    forward += r.acceleration_mps2.x() / kCount;
    sideways += r.acceleration_mps2.y() / kCount;
    up += r.acceleration_mps2.z() / kCount;
  }
  const double deviation = noise.gyro_noise_radpsrthz / std::sqrt(kDt);
  EXPECT_NEAR(sum / kCount, 0, 4 * deviation / std::sqrt(kCount));
  EXPECT_NEAR(std::sqrt(squares / kCount), deviation, 0.03 * deviation);
  EXPECT_NEAR(forward, 0, 0.01);
  EXPECT_NEAR(sideways, 0.5 * 0.8, 0.01);
  EXPECT_NEAR(up, 9.80665, 0.01);
}

TEST(SimImu, BiasesDifferBetweenSeedsAndSpeedingUpIsFelt) {
  ImuNoise quiet;
  quiet.gyro_noise_radpsrthz = quiet.accelerometer_noise_mps2rthz = 0;
  SimImu a(quiet, 1), b(quiet, 2);
  const ImuReading first = a.read({0, 0}, 0.01);
  EXPECT_NE(first.angular_velocity_radps.z(), b.read({0, 0}, 0.01).angular_velocity_radps.z());
  EXPECT_NEAR(a.read({0.01, 0}, 0.01).acceleration_mps2.x() - first.acceleration_mps2.x(), 1.0, 1e-9);
}

TEST(SimOdometry, WithoutNoiseItIsTheTruthFromTheStart) {
  SimOdometry odometry({0, 0, 0, 0}, 1);
  Pose2 pose{2, 1, 0.5};
  const Pose T_world_start = pose.to_pose();
  (void)odometry.move_to(pose);
  SimulatedStep step;
  for (int i = 0; i < 50; ++i) {
    pose = move_along_arc(pose, {0.5, 0.4}, 0.2);
    step = odometry.move_to(pose);
  }
  // What a standing camera measures is not exact either: 0.2 mm and 0.1 mrad a step.
  EXPECT_LT((T_world_start * step.T_odom_body.translation() - pose.to_pose().translation()).norm(), 0.01);
}

TEST(SimOdometry, ErrorsOverManySeedsAreAsStated) {
  double normalised = 0;
  constexpr int kSeeds = 400;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SimOdometry odometry({}, static_cast<std::uint64_t>(seed));
    Pose2 pose;
    SimulatedStep first, second;
    (void)odometry.move_to(pose);
    first = odometry.move_to(move_along_arc(pose, {0.5, 0.4}, 0.2));
    const Pose2 next = move_along_arc(pose, {0.5, 0.4}, 0.2);
    second = odometry.move_to(move_along_arc(next, {0.5, 0.4}, 0.2));
    const Pose T_true = next.to_pose().inverse() * move_along_arc(next, {0.5, 0.4}, 0.2).to_pose();
    const Vector6d e = local(T_true, first.T_odom_body.inverse() * second.T_odom_body);
    const Matrix6d& P = second.step_covariance;
    normalised += (e(0) * e(0) / P(0, 0) + e(1) * e(1) / P(1, 1) + e(5) * e(5) / P(5, 5)) / (3 * kSeeds);
  }
  EXPECT_NEAR(normalised, 1, 0.15);
}

}  // namespace
}  // namespace arpent::sim
