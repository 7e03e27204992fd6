// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// A robot whose map is finished sees, by sphere tracing, a room in which something has changed.
#include "planning/local/fresh_obstacles.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/pose2.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

const PinholeCamera kCamera{160, 128, 94.25, 94.25, 79.5, 63.5};

Pose camera_at(const Pose2& body) {
  Pose T_body_cam = Pose::Identity();
  T_body_cam.linear() = R_body_from_camera_axes();
  T_body_cam.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return body.to_pose() * T_body_cam;
}

/// `sigma` times the square of the depth is the noise of stereo.
stereo::DepthMap render(const FlatWorld& world, const Pose& T_map_cam, std::mt19937& random, double sigma = 0.008) {
  std::normal_distribution<double> normal;
  stereo::DepthMap depth{kCamera, cv::Mat1f(128, 160, 0.0F), cv::Mat1f(128, 160, 0.0F)};
  for (int v = 0; v < 128; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Eigen::Vector3d ray = kCamera.unproject(u, v, 1), along = T_map_cam.linear() * ray;
      double z = 0.3;
      for (double gap = 1; gap > 0.002 && z < 6;) {
        const Eigen::Vector3d p = T_map_cam.translation() + z * along;
        gap = std::min(world.distance_m(p.head<2>(), p.z()), p.z());
        z += gap / ray.norm();
      }
      if (z < 6) depth.depth_m(v, u) = static_cast<float>(z + sigma * z * z * normal(random));
    }
  }
  return depth;
}

class FreshObstaclesTest : public testing::Test {
 protected:
  void know(const FlatWorld& world) { grid_.update(make_map(world, 0.1)); }
  void look(const FlatWorld& world, const Pose2& body, int images) {
    const Pose T = camera_at(body);
    for (int i = 0; i < images; ++i) fresh_.look(render(world, T, random_), T, grid_);
  }
  [[nodiscard]] std::size_t free_cells() const {
    const auto& states = grid_.states();
    return static_cast<std::size_t>(std::count(states.begin(), states.end(), CellState::kFree));
  }

  std::mt19937 random_{3};
  GroundGrid grid_{{}};
  FreshObstacles fresh_{{}};
};

class KnownWorld : public FreshObstaclesTest, public testing::WithParamInterface<unsigned> {};

TEST_P(KnownWorld, IsNothingNew) {
  random_.seed(GetParam());
  const FlatWorld world = random_world(random_, 6);
  know(world);
  const std::size_t before = free_cells();
  for (int i = 0; i < 20; ++i) {
    const Pose2 body{uniform(random_, 1, 7), uniform(random_, 1, 6), uniform(random_, -3, 3)};
    if (world.distance_m(body.position_m()) > 0.4) look(world, body, 2);
  }
  EXPECT_EQ(free_cells(), before);
}

INSTANTIATE_TEST_SUITE_P(Worlds, KnownWorld, testing::Range(1U, 6U));

TEST_F(FreshObstaclesTest, WhatAppearsIsInTheWayAfterTwoImagesAndSoIsWhatItHides) {
  FlatWorld world;
  know(world);
  const FlatBox box{{4.0, 3.5}, {0.3, 0.4}, 0, 0.0, 0.4};
  world.boxes.push_back(box);
  const Pose2 body{2.0, 3.5, 0};
  look(world, body, 1);
  EXPECT_EQ(grid_.state({3.72, 3.5}), CellState::kFree) << "one image may err";
  look(world, body, 1);
  for (double y = 3.15; y < 3.9; y += 0.1) {
    EXPECT_TRUE(grid_.state({3.675, y}) == CellState::kOccupied || grid_.state({3.725, y}) == CellState::kOccupied)
        << y;
    EXPECT_EQ(grid_.state({3.9, y}), CellState::kOccupied) << "behind its face, y = " << y;
  }
  EXPECT_EQ(grid_.state({3.4, 3.5}), CellState::kFree);
  EXPECT_EQ(grid_.state({3.9, 2.8}), CellState::kFree) << "beside it";
  look(world, {2.0, 1.0, 0}, 4);
  look(world, {3.0, 3.5, 3.1}, 4);
  EXPECT_EQ(grid_.state({3.9, 3.5}), CellState::kOccupied) << "it was not looked at again";
  EXPECT_EQ(grid_.mapped_state(grid_.cell_at({3.9, 3.5})), CellState::kFree) << "the map had no part in it";
}

TEST_F(FreshObstaclesTest, WhatGoesAwayIsFreeAgainWhenItIsSeenToBe) {
  FlatWorld world;
  know(world);
  const std::size_t before = free_cells();
  FlatWorld changed = world;
  changed.boxes.push_back({{4.0, 3.5}, {0.3, 0.4}, 0.3});
  look(changed, {2.2, 3.5, 0}, 3);
  ASSERT_LT(free_cells(), before - 50);
  look(world, {2.2, 3.5, 0}, 2);
  EXPECT_LT(free_cells(), before - 50) << "two images are too few";
  look(world, {2.2, 3.5, 0}, 2);
  EXPECT_EQ(free_cells(), before);
}

TEST_F(FreshObstaclesTest, WhatIsBelowOrAboveTheRobotIsNotInItsWay) {
  FlatWorld world;
  know(world);
  const std::size_t before = free_cells();
  world.boxes.push_back({{3.5, 3.5}, {0.3, 0.4}, 0, 0.8, 1.5});
  world.boxes.push_back({{3.5, 2.5}, {0.3, 0.4}, 0, 0.0, 0.08});
  look(world, {2.0, 3.0, 0}, 4);
  EXPECT_EQ(free_cells(), before);
}

TEST_F(FreshObstaclesTest, WhatIsTouchedIsInTheWayUntilImagesSeePastIt) {
  const FlatWorld world;
  know(world);
  const Footprint body({});
  const Pose2 pose{3.0, 3.5, 0};
  fresh_.touch(body, pose, grid_);
  EXPECT_EQ(grid_.state({3.0 + body.long_m() + 0.05, 3.5}), CellState::kOccupied) << "before its bow";
  for (const double y : {3.5 - body.short_m() - 0.05, 3.5 + body.short_m() + 0.05}) {
    EXPECT_EQ(grid_.state({3.05, y}), CellState::kOccupied) << "beside its front half";
    EXPECT_EQ(grid_.state({2.9, y}), CellState::kFree) << "beside its rear half";
  }
  EXPECT_EQ(grid_.state({3.3, 3.5}), CellState::kFree) << "where it stands";
  EXPECT_EQ(grid_.state({3.0 + body.long_m() + 0.2, 3.5}), CellState::kFree) << "farther than it can touch";
  look(world, {5.0, 3.5, 0}, 6);
  EXPECT_EQ(grid_.state({3.0 + body.long_m() + 0.05, 3.5}), CellState::kOccupied) << "it was not looked at";
  look(world, {1.5, 3.5, 0}, 6);
  EXPECT_EQ(grid_.state({3.0 + body.long_m() + 0.05, 3.5}), CellState::kFree);
}

TEST(FreshObstacles, ABandUpsideDownIsAnError) {
  FreshObstacleParams params;
  params.min_height_m = 0.7;
  EXPECT_THROW(FreshObstacles{params}, InputError);
}

}  // namespace
}  // namespace arpent::planning
