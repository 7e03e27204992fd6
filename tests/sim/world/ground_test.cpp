// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/ground.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace arpent::sim {
namespace {

World empty_world() {
  World world;
  world.textures.emplace_back();
  return world;
}

World with_shape(const Shape& shape) {
  World world = empty_world();
  world.surfaces.push_back({shape, 0, 0});
  return world;
}

/// Brute force: is any of many points of the ellipse inside the box?
bool hits_densely(const Pose2& pose, const EllipseFootprint& footprint, const BoxShape& box) {
  const Pose T = pose.to_pose();
  for (double r = 0; r <= 1.0001; r += 0.02) {
    for (double a = 0; a < 2 * std::numbers::pi; a += 0.01) {
      const Eigen::Vector3d p =
          T * Eigen::Vector3d(r * footprint.semi_long_m * std::cos(a), r * footprint.semi_short_m * std::sin(a), 0);
      const Eigen::Vector2d q = Eigen::Rotation2Dd(-box.yaw_rad) * (p - box.centre_m).head<2>();
      if (std::abs(q.x()) <= 0.5 * box.size_m.x() && std::abs(q.y()) <= 0.5 * box.size_m.y()) return true;
    }
  }
  return false;
}

TEST(Ground, ContactOfAFootprintWithABoxAgreesWithBruteForce) {
  const BoxShape box{{1, 2, 0.5}, {0.8, 0.3, 1}, 0.6};
  const GroundMap ground(with_shape(box));
  const EllipseFootprint footprint;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int hits = 0, differ = 0;
  for (int i = 0; i < 300; ++i) {
    const Pose2 pose{1 + uniform(random), 2 + uniform(random), std::numbers::pi * uniform(random)};
    const bool hit = ground.hits(pose, footprint);
    hits += hit ? 1 : 0;
    if (hit == hits_densely(pose, footprint, box)) continue;
    // Brute force misses grazing contacts only: a slightly smaller robot must not touch.
    ++differ;
    EXPECT_TRUE(hit);
    EXPECT_FALSE(ground.hits(pose, {0.98 * footprint.semi_long_m, 0.98 * footprint.semi_short_m}));
  }
  EXPECT_GT(hits, 60);
  EXPECT_LT(hits, 240);
  EXPECT_LE(differ, 5);
}

TEST(Ground, DistancesFollowFormulas) {
  World world = with_shape(CylinderShape{{2, 0, 0}, 0.5, 1});
  world.surfaces.push_back({PlaneShape{{-3, -5, 0}, {0, 10, 0}, {0, 0, 2}}, 0, 0});  // the wall x = -3
  world.surfaces.push_back({BoxShape{{0, 4, 0.5}, {2, 2, 1}, 0}, 0, 0});
  const GroundMap ground(world);
  EXPECT_NEAR(ground.distance_m({0, 0}), 1.5, 1e-3) << "cylinder";
  EXPECT_NEAR(ground.distance_m({-2, 0}), 1.0, 1e-9) << "wall";
  EXPECT_NEAR(ground.distance_m({-1.3, 2.6}), std::hypot(0.3, 0.4), 1e-9) << "a corner of the box";
  EXPECT_EQ(ground.distance_m({0.5, 4.5}), 0) << "inside the box";
  EXPECT_NEAR(ground.distance_m({-40, 0}), 37, 1e-9) << "far outside";
  EXPECT_TRUE(std::isinf(GroundMap(empty_world()).distance_m({0, 0})));
}

TEST(Ground, OnlyWhatIsInTheHeightBandIsInTheWay) {
  const Pose2 here{0, 0, 0};
  const auto hit = [&](const Shape& shape) { return GroundMap(with_shape(shape)).hits(here, {}); };
  EXPECT_FALSE(hit(PlaneShape{{-2, -2, 0}, {4, 0, 0}, {0, 4, 0}})) << "floor";
  EXPECT_FALSE(hit(BoxShape{{0, 0, 1.0}, {1, 1, 0.7}})) << "a beam 0.65 m above ground";
  EXPECT_TRUE(hit(BoxShape{{0, 0, 0.9}, {1, 1, 0.7}})) << "a beam 0.55 m above ground";
  EXPECT_FALSE(hit(BoxShape{{0, 0, 0.005}, {1, 1, 0.01}})) << "a marking on the floor";
  EXPECT_TRUE(hit(BoxShape{{0, 0, 0.5}, {9, 9, 1}})) << "inside a large box, far from its faces";
  // A ramp that climbs 1 in 2 along x from x = 0.4: at 0.44 m it is 0.02 m high, and the robot reaches 0.55 m.
  EXPECT_TRUE(hit(PlaneShape{{0.4, -2, 0}, {2, 0, 1}, {0, 4, 0}}));
  EXPECT_FALSE(hit(PlaneShape{{0.52, -2, 0}, {2, 0, 1}, {0, 4, 0}}));
}

TEST(Ground, TheTagCubeIsInTheWay) {
  World world = empty_world();
  world.tag_cube = TagCube{};
  world.tag_cube->centre_m = {1, 0, 0.4};
  const GroundMap ground(world);
  EXPECT_TRUE(ground.hits({0.31, 0, 0}, {})) << "0.55 m ahead is the face at 0.85 m";
  EXPECT_FALSE(ground.hits({0.29, 0, 0}, {}));
}

TEST(Ground, RobotsOverlapWhenTheirEllipsesTouch) {
  const EllipseFootprint footprint;
  EXPECT_TRUE(overlap({0, 0, 0}, footprint, {1.09, 0, 0}, footprint)) << "nose to tail: 1.1 m";
  EXPECT_FALSE(overlap({0, 0, 0}, footprint, {1.11, 0, 0}, footprint));
  EXPECT_TRUE(overlap({0, 0, 0}, footprint, {0, 0.49, std::numbers::pi}, footprint)) << "side by side: 0.5 m";
  EXPECT_FALSE(overlap({0, 0, 0}, footprint, {0, 0.51, 0}, footprint));
  EXPECT_TRUE(overlap({0, 0, 0}, footprint, {0.79, 0, std::numbers::pi / 2}, footprint)) << "nose to side: 0.8 m";
  EXPECT_FALSE(overlap({0, 0, 0}, footprint, {0.81, 0, std::numbers::pi / 2}, footprint));
}

}  // namespace
}  // namespace arpent::sim
