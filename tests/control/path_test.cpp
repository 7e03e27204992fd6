// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "common/error.h"

namespace arpent::control {
namespace {

std::vector<Eigen::Vector2d> circle(double radius_m, double turns) {
  std::vector<Eigen::Vector2d> points;
  for (double a = 0; a <= 2 * std::numbers::pi * turns; a += 0.01) {
    points.emplace_back(radius_m * std::cos(a), radius_m * std::sin(a));
  }
  return points;
}

TEST(ControlPath, ACircleHasItsCurvatureAndItsHeadingNeverJumps) {
  const Path path(circle(0.5, 2.5), {});
  EXPECT_NEAR(path.length_m(), 2.5 * std::numbers::pi, 0.01);
  for (double s = 0.2; s < path.length_m() - 0.2; s += 0.05) {
    EXPECT_NEAR(path.at(s).curvature_1pm, 2.0, 0.05);
    EXPECT_NEAR(path.at(s).heading_rad - path.at(0.2).heading_rad, 2 * (s - 0.2), 0.02);
    EXPECT_NEAR(path.at(s).p_m.norm(), 0.5, 1e-3);
  }
}

TEST(ControlPath, SpeedsRespectEveryLimit) {
  const Limits limits;
  std::vector<Eigen::Vector2d> points = {{-2, -0.3}};
  for (double a = -std::numbers::pi / 2; a < std::numbers::pi / 2; a += 0.01) {
    points.emplace_back(0.3 * std::cos(a), 0.3 * std::sin(a));
  }
  points.emplace_back(-2, 0.3);
  const Path path(points, limits);
  EXPECT_EQ(path.at(path.length_m()).speed_mps, 0);
  constexpr double kStepM = 0.02;
  for (double s = 0; s + kStepM < path.length_m(); s += kStepM) {
    const double v = path.at(s).speed_mps, next = path.at(s + kStepM).speed_mps;
    EXPECT_LE(v, limits.max_speed_mps);
    EXPECT_LE(v * std::abs(path.at(s).curvature_1pm), limits.max_turn_rate_radps);
    EXPECT_LE((v * v - next * next) / (2 * kStepM), limits.max_acceleration_mps2) << "braking at " << s;
  }
  EXPECT_NEAR(path.at(1.0).speed_mps, limits.max_speed_mps, 1e-9);
}

TEST(ControlPath, ProjectionFindsTheNearestPointWithinItsBounds) {
  const Path path({{0, 0}, {3, 0}, {3, 3}}, {});
  EXPECT_NEAR(path.project({1.234, 0.4}, 0, 6), 1.234, 1e-6);
  EXPECT_NEAR(path.project({2.9, 2.0}, 0, 6), 5.0, 1e-6);
  EXPECT_NEAR(path.project({2.9, 2.0}, 0, 2), 2.0, 0.021) << "not beyond what was asked";
  EXPECT_EQ(path.project({-5, 1}, 0, 6), 0);
}

TEST(ControlPath, WhatIsNoPathIsRefused) {
  EXPECT_THROW(Path({}, {}), InputError);
  EXPECT_THROW(Path({{1, 1}}, {}), InputError);
  EXPECT_THROW(Path({{1, 1}, {1, 1}}, {}), InputError);
  EXPECT_THROW(Path({{1, 1}, {std::numeric_limits<double>::quiet_NaN(), 2}}, {}), InputError);
}

}  // namespace
}  // namespace arpent::control
