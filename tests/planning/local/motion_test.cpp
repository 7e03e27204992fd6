// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/motion.h"

#include <gtest/gtest.h>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

Pose2 random_pose(std::mt19937& random) {
  return {uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -3.1, 3.1)};
}

void expect_same(const Pose2& a, const Pose2& b, double tolerance = 1e-6) {
  EXPECT_NEAR(a.x_m, b.x_m, tolerance);
  EXPECT_NEAR(a.y_m, b.y_m, tolerance);
  EXPECT_NEAR(wrap_angle(a.yaw_rad - b.yaw_rad), 0, tolerance);
}

/// Integrates v = (cos, sin) by small steps.
Pose2 integrate(const Motion& motion) {
  constexpr int kSteps = 20000;
  Pose2 p = motion.start;
  const double ds = motion.length_m / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double middle = p.yaw_rad + 0.5 * ds * motion.curvature_1pm;
    p.x_m += ds * std::cos(middle);
    p.y_m += ds * std::sin(middle);
    p.yaw_rad += ds * motion.curvature_1pm;
  }
  p.yaw_rad += motion.turn_rad;
  return p;
}

TEST(Motion, EndsWhereIntegrationEnds) {
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    const Motion motion = drive(random_pose(random), uniform(random, 0.01, 4), uniform(random, -3, 3));
    expect_same(end_of(motion), integrate(motion));
  }
  const Motion turn = turn_to({1, 2, 3.0}, -3.0);
  EXPECT_NEAR(turn.turn_rad, 2 * std::numbers::pi - 6, 1e-12) << "the shorter way";
  expect_same(end_of(turn), {1, 2, -3.0});
}

void expect_connected(const Motions& motions, const Pose2& start, const Pose2& goal, double radius) {
  Pose2 at = start;
  for (const Motion& motion : motions) {
    expect_same(motion.start, at);
    EXPECT_LE(std::abs(motion.curvature_1pm), 1 / radius + 1e-12);
    at = end_of(motion);
  }
  expect_same(at, goal);
}

TEST(Motion, ConnectionsReachTheGoalWithinTheirCurvature) {
  std::mt19937 random(2);
  for (int i = 0; i < 500; ++i) {
    const Pose2 start = random_pose(random), goal = random_pose(random);
    const auto ways = connect_with_arcs(start, goal, 0.5);
    ASSERT_GE(ways.size(), 2U);
    for (const Motions& way : ways) {
      expect_connected(way, start, goal, 0.5);
      EXPECT_GE(length_of(way), (goal.position_m() - start.position_m()).norm() - 1e-9);
      EXPECT_GE(length_of(way), length_of(ways.front())) << "the shortest comes first";
    }
    for (const Motions& way : connect_then_turn(start, goal, 0.5)) expect_connected(way, start, goal, 0.5);
    expect_connected(turn_drive_turn(start, goal), start, goal, 0.5);
  }
}

TEST(Motion, TheShortestConnectionIsTheOneOfSamplingAllArcs) {
  // Of all ways arc, straight, arc the shortest: both arcs' angles sampled, the rest follows from the geometry. What
  // sampling finds ends near the goal and cannot be shorter by more than that error.
  std::mt19937 random(3);
  constexpr double kRadius = 0.5;
  constexpr int kAngles = 180;
  for (int trial = 0; trial < 8; ++trial) {
    const Pose2 start = random_pose(random), goal = random_pose(random);
    const double shortest = length_of(connect_with_arcs(start, goal, kRadius).front());
    double sampled = 1e9;
    for (const double s1 : {1.0, -1.0}) {
      for (const double s2 : {1.0, -1.0}) {
        for (int i = 0; i < kAngles; ++i) {
          const double a = 2 * std::numbers::pi * i / kAngles;
          const Pose2 left = end_of(drive(start, kRadius * a, s1 / kRadius));
          const double b_exact = s2 * (goal.yaw_rad - left.yaw_rad);
          const double b = b_exact - 2 * std::numbers::pi * std::floor(b_exact / (2 * std::numbers::pi));
          const Pose2 arc_end = end_of(drive({0, 0, left.yaw_rad}, kRadius * b, s2 / kRadius));
          const Eigen::Vector2d rest = goal.position_m() - left.position_m() - arc_end.position_m();
          const Eigen::Vector2d ahead(std::cos(left.yaw_rad), std::sin(left.yaw_rad));
          const double along = rest.dot(ahead);
          if (along < 0 || (rest - along * ahead).norm() > 0.05) continue;
          sampled = std::min(sampled, kRadius * (a + b) + along);
        }
      }
    }
    EXPECT_LT(sampled, 1e9);
    EXPECT_NEAR(shortest, sampled, 0.15) << "trial " << trial;
  }
}

}  // namespace
}  // namespace arpent::planning
