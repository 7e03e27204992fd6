// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/legal_views.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/tools/evaluation/small_worlds.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Does the segment meet the upright box? By slabs, for an unturned box.
bool meets_box(const Vector3d& from, const Vector3d& to, const Vector3d& low, const Vector3d& high) {
  double first = 0, last = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = to[axis] - from[axis];
    if (std::abs(d) < 1e-12) {
      if (from[axis] < low[axis] || from[axis] > high[axis]) return false;
      continue;
    }
    const double a = (low[axis] - from[axis]) / d, b = (high[axis] - from[axis]) / d;
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  return first < last;
}

TEST(LegalViews, PosesAreThoseThatTouchNothingAndAreConnectedWithTheStart) {
  // A wall of boxes across the room leaves nothing open: what lies behind cannot be reached, though it is free.
  const auto world = room_with("  - box: {centre_m: [3, 2, 0.75], size_m: [0.2, 4, 1.5], texture: plain}\n");
  const LegalViews views(world, {1, 2, 0}, small_robot());
  EXPECT_TRUE(views.is_reachable({1, 2, 0}));
  EXPECT_TRUE(views.is_reachable({2, 1, 1.57}));
  EXPECT_FALSE(views.is_reachable({4, 2, 1.57})) << "free, but behind the wall";
  EXPECT_FALSE(views.is_reachable({2.6, 2, 0})) << "0.3 m from the wall, 0.55 m long";
  EXPECT_TRUE(views.is_reachable({2.6, 2, std::numbers::pi / 2})) << "alongside it";
  EXPECT_FALSE(views.is_reachable({-1, 2, 0})) << "outside the region";
  EXPECT_FALSE(views.see({4, 2, 0}, {0, 0, 1}));
  EXPECT_TRUE(views.see({2, 2, 0}, {0, 0, 1}));
}

TEST(LegalViews, AGapThatTheBodyFitsThroughOpensWhatLiesBehind) {
  const auto gap = [](double width_m) {
    const double length = 4 - width_m;
    return room_with("  - box: {centre_m: [3, " + std::to_string(length / 2) + ", 0.75], size_m: [0.2, " +
                     std::to_string(length) + ", 1.5], texture: plain}\n");
  };
  EXPECT_TRUE(LegalViews(gap(0.8), {1, 2, 0}, small_robot()).is_reachable({4, 2, 1.57}));
  EXPECT_FALSE(LegalViews(gap(0.45), {1, 2, 0}, small_robot()).is_reachable({4, 2, 1.57})) << "0.50 m are needed";
}

TEST(LegalViews, CountsEqualBruteForceOverAllPoses) {
  const Vector3d low(2.4, 1.4, 0), high(3.2, 2.2, 0.6);
  const auto world = room_with("  - box: {centre_m: [2.8, 1.8, 0.3], size_m: [0.8, 0.8, 0.6], texture: plain}\n");
  LegalViewParams params = small_robot();
  params.view_m = 0.5;
  const LegalViews views(world, {1, 2, 0}, params);
  const sim::GroundMap ground(world);
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  int seen = 0, partly = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Vector3d p(5 * uniform(generator), 4 * uniform(generator), 1.4 * uniform(generator));
    LegalViews::Count expected;
    // The lattice of camera positions begins at the region's corner, less the camera's distance from the body's origin.
    const double margin = std::hypot(0.20, 0.13);
    for (double y = -margin; y < 4 + margin; y += 0.5) {
      for (double x = -margin; x < 5 + margin; x += 0.5) {
        for (int h = 0; h < LegalViews::kHeadings; ++h) {
          const double yaw = wrap_angle(2 * std::numbers::pi * h / LegalViews::kHeadings);
          const double c = std::cos(yaw), s = std::sin(yaw);
          const Pose2 body{x - 0.20 * c + 0.13 * s, y - 0.20 * s - 0.13 * c, yaw};
          const planning::CameraView view(params.camera, body);
          if (!views.is_reachable(body) || !view.contains(p)) continue;
          ++expected.in_view;
          expected.in_sight += meets_box(view.position_m(), p, low, high) ? 0 : 1;
        }
      }
    }
    const auto count = views.count(p, 0);
    EXPECT_EQ(count.in_view, expected.in_view) << p.transpose();
    EXPECT_EQ(count.in_sight, expected.in_sight) << p.transpose();
    seen += count.in_sight > 0 ? 1 : 0;
    partly += count.in_sight > 0 && count.in_sight < count.in_view ? 1 : 0;
  }
  EXPECT_GT(seen, 20);
  EXPECT_GT(partly, 20);
}

TEST(LegalViews, ABeamNeedsRoomOnAllSides) {
  // A slot of 0.12 m between two tall boxes, and the free floor beside it.
  const auto world = room_with(
      "  - box: {centre_m: [3, 0.97, 0.5], size_m: [0.4, 1.94, 1], texture: plain}\n"
      "  - box: {centre_m: [3, 2.91, 0.5], size_m: [0.4, 1.7, 1], texture: plain}\n");
  const LegalViews views(world, {1, 2, 0}, small_robot());
  const Eigen::Vector3d through(3.4, 2.0, 0.4), open(2.0, 2.0, 0.4);
  EXPECT_GT(views.count(through, 0).in_sight, 0);
  EXPECT_GT(views.count(through, 0, 0.04).in_sight, 0);
  EXPECT_EQ(views.count(through, 0, 0.0866).in_sight, 0);
  EXPECT_EQ(views.count(open, 0, 0.0866).in_view, views.count(open, 0).in_view);
  EXPECT_GT(views.count(open, 0, 0.0866).in_sight, 0);
}

TEST(LegalViews, FlatLooksDoNotCount) {
  // The top of a box of 0.35 m: 5 cm below the camera, so that from 0.3 m on its normal is more than 80 degrees off.
  const auto world = room_with("  - box: {centre_m: [3, 2, 0.175], size_m: [0.4, 0.4, 0.35], texture: plain}\n");
  LegalViewParams params = small_robot();
  EXPECT_FALSE(LegalViews(world, {1, 2, 0}, params).see({3, 2, 0.35}, {0, 0, 1}));
  params.max_incidence_deg = 89.9;
  EXPECT_TRUE(LegalViews(world, {1, 2, 0}, params).see({3, 2, 0.35}, {0, 0, 1}));
}

}  // namespace
}  // namespace arpent::evaluation
