// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/loop.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/error.h"

namespace arpent::planning {
namespace {

LoopParams square() {
  LoopParams params;
  params.centre_m = {4.9, 3.5};
  params.entry_m = {4.9, 2.0};
  return params;
}

double length_m(const std::vector<Eigen::Vector2d>& points) {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

TEST(Loop, LapsHaveTheLengthOfStraightsAndQuarterCircles) {
  LoopParams once = square(), twice = square();
  once.laps = 1;
  const Pose2 start{1.0, 2.4, 0.7};
  // Sides 4 and 3 m less two radii each, and one full circle.
  const double lap = 2 * (4 - 1.5) + 2 * (3 - 1.5) + 2 * std::numbers::pi * 0.75;
  EXPECT_NEAR(length_m(make_loop(start, twice)) - length_m(make_loop(start, once)), lap, 0.01);
}

TEST(Loop, BeginsAtTheStartEndsAtTheEntryAndTurnsSmoothly) {
  const auto points = make_loop({1.0, 2.4, 0.7}, square());
  EXPECT_EQ(points.front(), Eigen::Vector2d(1.0, 2.4));
  EXPECT_NEAR((points.back() - Eigen::Vector2d(4.9, 2.0)).norm(), 0, 1e-9);
  double last = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Eigen::Vector2d step = points[i] - points[i - 1];
    EXPECT_LE(step.norm(), 0.0501);
    const double heading = std::atan2(step.y(), step.x());
    if (i > 1) {
      EXPECT_LT(std::abs(wrap_angle(heading - last)), 0.08) << "at point " << i;
    }
    last = heading;
  }
}

TEST(Loop, StaysWithinTheRectangleAndGoesCounterClockwise) {
  const auto points = make_loop({1.0, 2.4, 0.7}, square());
  double area = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].x() < 2.9 - 1e-9) continue;
    EXPECT_LE(points[i].x(), 6.9 + 1e-9);
    EXPECT_LE(points[i].y(), 5.0 + 1e-9);
    const Eigen::Vector2d c(4.9, 3.5);
    const Eigen::Vector2d a = points[i - 1] - c, b = points[i] - c;
    area += 0.5 * (a.x() * b.y() - a.y() * b.x());
  }
  EXPECT_GT(area, 2 * 11.0);
}

TEST(Loop, ALoopThatCannotBeIsRefused) {
  LoopParams wide = square();
  wide.corner_radius_m = 1.6;
  EXPECT_THROW((void)make_loop({}, wide), InputError);
  LoopParams off = square();
  off.entry_m = {4.9, 2.2};
  EXPECT_THROW((void)make_loop({}, off), InputError);
  off.entry_m = {6.8, 2.0};
  EXPECT_THROW((void)make_loop({}, off), InputError);
}

}  // namespace
}  // namespace arpent::planning
