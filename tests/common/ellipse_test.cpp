// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/ellipse.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace arpent {
namespace {

constexpr double kLong = 0.55, kShort = 0.25;

bool contains(const Pose2& pose, const Eigen::Vector2d& p) {
  const Eigen::Vector2d q = Eigen::Rotation2Dd(-pose.yaw_rad) * (p - pose.position_m());
  return std::hypot(q.x() / kLong, q.y() / kShort) <= 1;
}

/// Whether a point of a fine lattice over `a` lies in both.
bool overlap_by_sampling(const Pose2& a, const Pose2& b) {
  for (double x = -kLong; x <= kLong; x += 0.005) {
    for (double y = -kShort; y <= kShort; y += 0.005) {
      const Eigen::Vector2d p = a.position_m() + Eigen::Rotation2Dd(a.yaw_rad) * Eigen::Vector2d(x, y);
      if (contains(a, p) && contains(b, p)) return true;
    }
  }
  return false;
}

TEST(Ellipses, AgreeWithSamplingAtRandomPoses) {
  std::mt19937 random(5);
  const auto draw = [&](double most) { return most * (2 * static_cast<double>(random()) * 0x1p-32 - 1); };
  int together = 0, differ = 0;
  for (int i = 0; i < 400; ++i) {
    const Pose2 a{draw(10), draw(10), draw(4)};
    const Pose2 b{a.x_m + draw(1.0), a.y_m + draw(1.0), draw(4)};
    const bool sampled = overlap_by_sampling(a, b);
    EXPECT_EQ(ellipses_overlap(kLong, kShort, a, b), ellipses_overlap(kLong, kShort, b, a));
    EXPECT_TRUE(!sampled || ellipses_overlap(kLong, kShort, a, b)) << "a common point was found";
    together += sampled ? 1 : 0;
    differ += sampled != ellipses_overlap(kLong, kShort, a, b) ? 1 : 0;
  }
  EXPECT_GT(together, 80);
  EXPECT_LT(differ, 6) << "overlaps smaller than the lattice";
}

TEST(Ellipses, TouchWhereArithmeticSays) {
  EXPECT_TRUE(ellipses_overlap(kLong, kShort, {}, {1.0999, 0, 0}));
  EXPECT_FALSE(ellipses_overlap(kLong, kShort, {}, {1.1001, 0, 0}));
  EXPECT_TRUE(ellipses_overlap(kLong, kShort, {}, {0, 0.4999, 3.14159265358979}));
  EXPECT_FALSE(ellipses_overlap(kLong, kShort, {}, {0, 0.5001, 0}));
  EXPECT_TRUE(ellipses_overlap(kLong, kShort, {}, {0.7999, 0, 1.57079632679490}));  // nose to flank: 0.55 + 0.25
  EXPECT_FALSE(ellipses_overlap(kLong, kShort, {}, {0.8001, 0, 1.57079632679490}));
  EXPECT_TRUE(ellipses_overlap(kLong, kShort, {1, 2, 0.3}, {1, 2, 0.3}));
}

}  // namespace
}  // namespace arpent
