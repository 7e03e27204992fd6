// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Viewpoints of the thesis against numbers worked out by hand.
#include "planning/viewpoints/generation.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/planning/viewpoints/grid_free_space.h"
#include "tests/planning/viewpoints/scene.h"

namespace arpent::planning {
namespace {

using mapping::IncompleteElement;
using std::numbers::pi;

IncompleteElement element_at(const Eigen::Vector3d& p, const Eigen::Vector3d& direction) {
  IncompleteElement element;
  element.voxel = (p / 0.2).array().floor().cast<int>();
  element.centre_m = p;
  element.direction = direction.normalized();
  return element;
}

std::vector<Viewpoint> generate(const IncompleteElement& element, const FreeSpace& free_space) {
  ViewpointParams params;
  params.preset = "thesis";
  return generate_viewpoints(std::span(&element, 1), rig_camera(), params, free_space, {});
}

TEST(Generation, StandsDeltaPoseAwayInTheDirectionOfTheElement) {
  // Camera at x = 3.0 - 1.3 = 1.7, body 0.2 m behind it.
  const auto viewpoints = generate(element_at({3.0, 0, 0.5}, {-1, 0, 0.3}), OpenGround());
  ASSERT_EQ(viewpoints.size(), 1U);
  EXPECT_NEAR(viewpoints[0].pose.x_m, 1.5, 1e-12);
  EXPECT_NEAR(viewpoints[0].pose.y_m, 0.0, 1e-12);
  EXPECT_NEAR(viewpoints[0].pose.yaw_rad, 0.0, 1e-12);
  EXPECT_EQ(viewpoints[0].elements, std::vector<VoxelIndex>{VoxelIndex(15, 0, 2)});
}

TEST(Generation, StandsFartherFromWhatIsHigh) {
  // 1.6 m above the camera: max(1.3, 1.6 / (256 / 377)) = 2.35625, so the camera is at y = 2.35625.
  const auto viewpoints = generate(element_at({3.0, 0, 2.0}, {0, 1, 0}), OpenGround());
  ASSERT_EQ(viewpoints.size(), 1U);
  EXPECT_NEAR(viewpoints[0].pose.x_m, 3.0, 1e-12);
  EXPECT_NEAR(viewpoints[0].pose.y_m, 2.35625 + 0.2, 1e-9);
  EXPECT_NEAR(viewpoints[0].pose.yaw_rad, -pi / 2, 1e-12);
  // 3.6 / (256 / 377) = 5.3 m is out of range.
  EXPECT_TRUE(generate(element_at({3.0, 0, 4.0}, {0, 1, 0}), OpenGround()).empty());
}

TEST(Generation, TurnsToTheNextPoseOfTheRingWhereTheFirstIsBlocked) {
  // The first, +30 and -30 degrees stand at x <= 3 - 1.3 cos 30 - 0.2 cos 30 = 1.70; +60 at 3 - 1.5 cos 60 = 2.25.
  const GridFreeSpace free_space({-5, -5}, {8, 8}, 0.1, [](const Eigen::Vector2d& p) { return p.x() > 1.85; });
  const IncompleteElement element = element_at({3.0, 0, 0.4}, {-1, 0, 0});
  ViewpointParams params;
  const Pose2 robot{3, 3, 0};
  const auto viewpoints = generate_viewpoints(std::span(&element, 1), rig_camera(), params, free_space, robot);
  ASSERT_EQ(viewpoints.size(), 1U);
  EXPECT_NEAR(viewpoints[0].pose.x_m, 2.25, 1e-9);
  EXPECT_NEAR(std::abs(viewpoints[0].pose.y_m), 1.5 * std::sin(pi / 3), 1e-9);
  const Pose2 nowhere{-4, 0, 0};
  EXPECT_TRUE(generate_viewpoints(std::span(&element, 1), rig_camera(), params, free_space, nowhere).empty())
      << "free, but not to be reached from there";
}

TEST(Generation, RingsGoFromTheNearestDirectionOutwardsAndAllRound) {
  const auto azimuths = azimuths_around(element_at({0, 0, 0}, {0, 1, 0}), 4);
  ASSERT_EQ(azimuths.size(), 4U);
  EXPECT_NEAR(azimuths[0], pi / 2, 1e-12);
  EXPECT_NEAR(std::abs(azimuths[1]), pi, 1e-12);
  EXPECT_NEAR(azimuths[2], 0, 1e-12);
  EXPECT_NEAR(azimuths[3], -pi / 2, 1e-12);
  EXPECT_TRUE(is_steep(element_at({0, 0, 0}, {0.1, 0, 1}), 30));
  EXPECT_FALSE(is_steep(element_at({0, 0, 0}, {1, 0, 1}), 30));
}

std::vector<Viewpoint> viewpoints_at(const std::vector<Pose2>& poses) {
  std::vector<Viewpoint> viewpoints;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    viewpoints.push_back({poses[i], {VoxelIndex(static_cast<int>(i), 0, 0)}, 1});
  }
  return viewpoints;
}

constexpr double kDegree = pi / 180;

TEST(Merging, TakesTheMeanOfNearAndNearlyParallelViewpoints) {
  const auto merged =
      merge_viewpoints(viewpoints_at({{1, 0, 0}, {1.2, 0.1, 10 * kDegree}}), 0.4, 15 * kDegree, OpenGround());
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_NEAR(merged[0].pose.x_m, 1.1, 1e-12);
  EXPECT_NEAR(merged[0].pose.y_m, 0.05, 1e-12);
  EXPECT_NEAR(merged[0].pose.yaw_rad, 5 * kDegree, 1e-12);
  EXPECT_EQ(merged[0].elements.size(), 2U) << "it keeps all its elements";
}

TEST(Merging, LeavesApartWhatIsFarOrLooksElsewhereOrWouldStandInAnObstacle) {
  EXPECT_EQ(merge_viewpoints(viewpoints_at({{1, 0, 0}, {1.41, 0, 0}}), 0.4, 15 * kDegree, OpenGround()).size(), 2U);
  EXPECT_EQ(merge_viewpoints(viewpoints_at({{1, 0, 0}, {1, 0, 16 * kDegree}}), 0.4, 15 * kDegree, OpenGround()).size(),
            2U);
  EXPECT_EQ(merge_viewpoints(viewpoints_at({{1, 0, 0}, {1, 0, pi}}), 0.4, 15 * kDegree, OpenGround()).size(), 2U)
      << "opposite views are parallel, but cannot be averaged";
  const GridFreeSpace gap({0, -1}, {3, 1}, 0.1, [](const Eigen::Vector2d& p) { return std::abs(p.x() - 1.1) > 0.06; });
  EXPECT_EQ(merge_viewpoints(viewpoints_at({{1, 0, 0}, {1.2, 0, 0}}), 0.4, 15 * kDegree, gap).size(), 2U);
}

}  // namespace
}  // namespace arpent::planning
