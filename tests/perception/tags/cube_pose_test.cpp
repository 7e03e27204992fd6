// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/cube_pose.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "tests/perception/tags/cube_pictures.h"

namespace arpent::tags {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Outlines as exact projections give them, with errors of the sides as their covariance says.
struct Scene {
  TagCube cube{TagCubeConfig{}};
  RectifiedStereo stereo = make_stereo();
  Pose T_body_cam = make_T_body_cam();

  [[nodiscard]] ImageCorners project(int id, bool in_right, const Pose& T_world_body) const {
    const Pose T_cam_world =
        (T_world_body * T_body_cam * Eigen::Translation3d(in_right ? stereo.baseline_m : 0, 0, 0)).inverse();
    ImageCorners corners;
    for (std::size_t k = 0; k < 4; ++k) {
      corners[k] = stereo.camera.project(T_cam_world * (*cube.find_corners(id))[k]);
    }
    return corners;
  }

  [[nodiscard]] static TagOutline outline_of(const ImageCorners& corners, double sigma_px, std::mt19937& generator) {
    std::normal_distribution<double> normal(0, sigma_px);
    TagOutline outline;
    outline.corners_px = corners;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vector2d along = (corners[(k + 1) % 4] - corners[k]).normalized();
      const Vector2d outwards(-along.y(), along.x());
      const Vector2d a = corners[k] + normal(generator) * outwards;
      const Vector2d b = corners[(k + 1) % 4] + normal(generator) * outwards;
      TagSide& side = outline.sides[k];
      side.normal = Vector2d(-(b - a).y(), (b - a).x()).normalized();
      side.offset_px = side.normal.dot(a);
      side.covariance_px2 = Eigen::Matrix2d::Identity() * sigma_px * sigma_px;
    }
    return outline;
  }

  [[nodiscard]] std::vector<TagView> views(const std::vector<int>& ids, const Pose& pose, double sigma_px,
                                           unsigned seed) const {
    std::mt19937 generator(seed);
    std::vector<TagView> all;
    for (const bool right : {false, true}) {
      for (const int id : ids) all.push_back({id, right, outline_of(project(id, right, pose), sigma_px, generator)});
    }
    return all;
  }
};

Pose tilted(Pose pose, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-0.05, 0.05);
  Vector6d d;
  for (int k = 0; k < 6; ++k) d[k] = uniform(generator);
  return retract(pose, d);
}

TEST(TagCubePose, ExactSidesGiveTheExactPose) {
  const Scene scene;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Pose truth = tilted(pose_facing({}, 0.9 + 0.1 * seed, 0.75, 0.1), seed);
    const CubePose one = solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, scene.views({0}, truth, 1e-3, 1));
    ASSERT_TRUE(one.usable()) << one.reason;
    EXPECT_LT(local(truth, one.T_world_body).norm(), 3e-3);
    const CubePose two =
        solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, scene.views({0, 1}, truth, 1e-6, 1));
    ASSERT_TRUE(two.usable()) << two.reason;
    EXPECT_LT(local(truth, two.T_world_body).norm(), 1e-5);
    EXPECT_EQ(two.used, (std::vector<int>{0, 1}));
  }
}

TEST(TagCubePose, ErrorsAreAsLargeAsTheCovarianceSays) {
  const Scene scene;
  double nees = 0, chi2 = 0;
  constexpr int kTrials = 200;
  for (unsigned seed = 0; seed < kTrials; ++seed) {
    const Pose truth = tilted(pose_facing({}, 2.0, 0.0 + 0.004 * seed, 0.1), seed);
    const CubePose pose =
        solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam,
                        scene.views(seed % 2 ? std::vector<int>{0} : std::vector<int>{0, 1}, truth, 0.05, seed));
    ASSERT_TRUE(pose.usable()) << pose.reason;
    const Vector6d d = local(truth, pose.T_world_body);
    nees += d.dot(pose.covariance.ldlt().solve(d)) / 6 / kTrials;
    chi2 += pose.reduced_chi2 / kTrials;
  }
  // The covariance never shrinks below what the sides say, so that the mean lies a little below 1; 6 x 200 squares
  // have a deviation of 0.04.
  EXPECT_GT(nees, 0.75);
  EXPECT_LT(nees, 1.12);
  EXPECT_NEAR(chi2, 1.0, 0.1);
}

TEST(TagCubePose, TwoFacesKnowTheHeadingBetterThanOneFrontalFace) {
  const Scene scene;
  const auto yaw_sigma = [&](const std::vector<int>& ids, double bearing_rad) {
    const Pose truth = pose_facing({}, 2.0, bearing_rad, 0);
    return std::sqrt(
        solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, scene.views(ids, truth, 0.02, 1)).covariance(5, 5));
  };
  EXPECT_GT(yaw_sigma({0}, 0.0), 3 * yaw_sigma({0, 1}, M_PI / 4));
}

TEST(TagCubePose, OneCameraAloneIsNotEnough) {
  const Scene scene;
  auto views = scene.views({0}, pose_facing({}, 2.0, 0.3, 0), 0.02, 1);
  views.pop_back();
  const CubePose pose = solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, views);
  EXPECT_FALSE(pose.usable());
  EXPECT_EQ(pose.reason, "no tag of the cube was seen in both images");
  EXPECT_FALSE(solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, {}).usable());
}

TEST(TagCubePose, ATagOfAnotherSizeDoesNotFit) {
  TagCubeConfig painted;
  painted.tag_m = 0.22;
  Scene other;
  other.cube = TagCube(painted);
  const Scene scene;
  for (int i = 0; i < 20; ++i) {
    const auto views = other.views({0}, pose_facing({}, 0.8 + 0.1 * i, 0.02 * i, 0), 0.02, 1);
    const CubePose pose = solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, views);
    EXPECT_EQ(pose.reason, "the tags do not fit the cube") << i;
  }
}

TEST(TagCubePose, AFaceThatContradictsTheOthersLeavesNoPoseOrOneWithoutIt) {
  const Scene scene;
  const Pose truth = pose_facing({}, 1.5, M_PI / 4, 0);
  auto views = scene.views({0, 1}, truth, 0.02, 1);
  // Half of face 1 is hidden by something of its own colour: no square any more. The rest fits without it.
  for (TagView& view : views) {
    if (view.id != 1) continue;
    view.outline.sides[1].offset_px -= 6;
    for (const std::size_t k : {1U, 2U}) view.outline.corners_px[k] -= 6 * view.outline.sides[1].normal;
  }
  const CubePose without = solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, views);
  ASSERT_TRUE(without.usable()) << without.reason;
  EXPECT_EQ(without.used, std::vector<int>{0});
  EXPECT_LT(local(truth, without.T_world_body).norm(), 0.05);
  // Two faces with exchanged tags: each alone would fit.
  auto exchanged = scene.views({0, 1}, truth, 0.02, 1);
  for (TagView& view : exchanged) view.id = 1 - view.id;
  EXPECT_FALSE(solve_cube_pose(scene.cube, scene.stereo, scene.T_body_cam, exchanged).usable());
}

TEST(TagCubePose, TheGroundPullsAsAMeasurementInLeastSquaresWould) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  const GroundParams params{0.02, 0.01};
  for (int trial = 0; trial < 10; ++trial) {
    const Pose measured = tilted(pose_facing({}, 2.0, 0.5 * trial, 0), static_cast<unsigned>(trial));
    Matrix6d A;
    for (int k = 0; k < 36; ++k) A(k) = normal(generator);
    const Matrix6d C = 1e-5 * (A * A.transpose() + Matrix6d::Identity());
    const GroundedPose grounded = put_on_ground(measured, C, params);
    // The same by Gauss-Newton with a numeric derivative: minimise d' C^-1 d + |h(T (+) d)|^2 / sigma^2.
    const auto ground = [&](const Vector6d& d) {
      const Pose T = retract(measured, d);
      return Vector3d(T.translation().z() / 0.02, T.linear()(0, 2) / 0.01, T.linear()(1, 2) / 0.01);
    };
    Eigen::Matrix<double, 3, 6> J;
    for (int k = 0; k < 6; ++k) {
      const Vector6d step = 1e-6 * Vector6d::Unit(k);
      J.col(k) = (ground(step) - ground(-step)) / 2e-6;
    }
    const Matrix6d information = C.inverse() + J.transpose() * J;
    const Vector6d d = information.inverse() * (-J.transpose() * ground(Vector6d::Zero()));
    EXPECT_LT(local(retract(measured, d), grounded.T_world_body).norm(), 1e-8);
    EXPECT_TRUE(grounded.covariance.isApprox(information.inverse(), 1e-6));
    const Eigen::Matrix3d S = J * C * J.transpose() + Eigen::Matrix3d::Identity();
    EXPECT_NEAR(grounded.chi2, ground(Vector6d::Zero()).dot(S.inverse() * ground(Vector6d::Zero())),
                1e-6 * grounded.chi2);
  }
}

}  // namespace
}  // namespace arpent::tags
