// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/motion_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace arpent::fusion {
namespace {

struct Case {
  Interval interval;
  Estimated estimated;
};

Case draw(std::mt19937& random, bool gyro) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Case c;
  c.interval.duration_s = 0.05;
  c.interval.wheels = {0.05 * uniform(random), 0.1 * uniform(random), false};
  if (gyro) c.interval.gyro_rad = 0.1 * uniform(random);
  c.estimated = {0.1 * uniform(random), 0.1 * uniform(random), 0.1 * uniform(random), {}};
  return c;
}

/// The pose after the step, as a function of the error state before it, by nothing but the step itself.
Pose moved(const Case& c, const Pose& T, const Eigen::Matrix<double, kClone, 1>& dx) {
  Case shifted = c;
  shifted.estimated.gyro_bias_radps += dx(kGyroBias);
  shifted.estimated.distance_scale += dx(kDistanceScale);
  shifted.estimated.turn_scale += dx(kTurnScale);
  const MotionStep step = make_motion_step(shifted.interval, shifted.estimated, true, {});
  return retract(T, dx.head<6>()) * step.T_before_after;
}

TEST(FusionMotionStep, ItsJacobianIsTheDerivativeOfTheMotion) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const Case c = draw(random, i % 2 == 0);
    const MotionStep step = make_motion_step(c.interval, c.estimated, true, {});
    const Pose T = Eigen::Translation3d(1, 2, 0.1) * Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ());
    for (int k = 0; k < kClone; ++k) {
      constexpr double kStep = 1e-6;
      Eigen::Matrix<double, kClone, 1> dx = Eigen::Matrix<double, kClone, 1>::Zero();
      dx(k) = kStep;
      const Vector6d after = local(moved(c, T, -dx), moved(c, T, dx)) / (2 * kStep);
      Vector6d expected = step.F.col(k).head<6>();
      expected.segment<3>(2) /= step.ground_keep;  // the reversion to the ground is not in this function
      EXPECT_LT((after - expected).norm(), 1e-6) << i << ' ' << k;
    }
  }
}

TEST(FusionMotionStep, AnArcEndsWhereItsChordAndTurnSay) {
  // A quarter circle of radius 1 m in small steps: ends at (1, 1) with heading 90 degrees.
  Interval interval;
  interval.duration_s = 0.01;
  interval.wheels = {M_PI / 2 / 1000, M_PI / 2 / 1000, false};
  Pose T = Pose::Identity();
  for (int i = 0; i < 1000; ++i) T = T * make_motion_step(interval, {}, true, {}).T_before_after;
  EXPECT_NEAR(T.translation().x(), 1, 1e-5);
  EXPECT_NEAR(T.translation().y(), 1, 1e-5);
  EXPECT_NEAR(so3_log(T.linear()).z(), M_PI / 2, 1e-9);
}

TEST(FusionMotionStep, NoiseAddsUpOverTheWayWhateverTheSteps) {
  // 4 m straight on: along 0.01 * sqrt(4) = 0.02 m, in one step or in many.
  FusionParams params;
  params.wheels.distance_scale_sigma = 0;
  for (const int steps : {1, 100}) {
    Interval interval;
    interval.duration_s = 8.0 / steps;
    interval.wheels = {4.0 / steps, 0, false};
    interval.gyro_rad = 0;
    MotionCovariance P = MotionCovariance::Zero();
    for (int i = 0; i < steps; ++i) apply(make_motion_step(interval, {}, true, params), P);
    EXPECT_NEAR(std::sqrt(P(0, 0)), 0.02, 0.001) << steps;
    EXPECT_NEAR(std::sqrt(P(5, 5)), 0.002 * std::sqrt(8), 0.0005) << steps;
  }
}

TEST(FusionMotionStep, RollPitchAndHeightRevertToTheGroundAndTheRestStays) {
  const Pose T = Eigen::Translation3d(3, -2, 0.2) * Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitZ()) *
                 Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX());
  const Pose half = revert_to_ground(T, 0.5);
  EXPECT_NEAR(half.translation().z(), 0.1, 1e-12);
  EXPECT_NEAR(half.translation().x(), 3, 1e-12);
  EXPECT_NEAR(std::atan2(half.linear()(1, 0), half.linear()(0, 0)), 2.0, 1e-12);
  EXPECT_NEAR(std::acos(half.linear()(2, 2)), 0.05, 1e-12);
  EXPECT_EQ(revert_to_ground(T, 1).matrix(), T.matrix());
}

TEST(FusionMotionStep, TheGroundsDeviationStaysWhatItIs) {
  // An Ornstein-Uhlenbeck process in its stationary state.
  FusionParams params;
  Interval interval;
  interval.duration_s = 0.1;
  interval.wheels = {0.05, 0, false};
  interval.gyro_rad = 0;
  MotionCovariance P = MotionCovariance::Zero();
  for (int i = 0; i < 2000; ++i) apply(make_motion_step(interval, {}, true, params), P);
  EXPECT_NEAR(std::sqrt(P(3, 3)), params.ground.sigma_rad, 1e-4);
  EXPECT_NEAR(std::sqrt(P(4, 4)), params.ground.sigma_rad, 1e-4);
  EXPECT_GT(std::sqrt(P(2, 2)), params.ground.sigma_m) << "pitch lifts it as well";
  EXPECT_LT(std::sqrt(P(2, 2)), 3 * params.ground.sigma_m);
}

}  // namespace
}  // namespace arpent::fusion
