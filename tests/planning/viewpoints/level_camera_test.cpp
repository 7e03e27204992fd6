// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The planar view against projection through both cameras.
#include "planning/viewpoints/level_camera.h"

#include <gtest/gtest.h>

#include <random>

#include "common/error.h"
#include "tests/planning/viewpoints/scene.h"

namespace arpent::planning {
namespace {

bool in_image(const PinholeCamera& camera, const Eigen::Vector3d& p_cam) {
  const Eigen::Vector2d pixel = camera.project(p_cam);
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() <= camera.width_px - 0.5 &&
         pixel.y() <= camera.height_px - 0.5;
}

TEST(LevelCamera, ContainsWhatBothCamerasProjectIntoTheirImages) {
  const LevelCamera camera = rig_camera();
  const RectifiedStereo stereo = rig_stereo();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> at(-6, 6), height(-1, 4), yaw(-3.2, 3.2);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Pose2 pose{0.2 * at(random), 0.2 * at(random), yaw(random)};
    const Eigen::Vector3d p(at(random), at(random), height(random));
    const Eigen::Vector3d p_left = (pose.to_pose() * T_body_rig()).inverse() * p;
    const Eigen::Vector3d p_right = p_left - Eigen::Vector3d(stereo.baseline_m, 0, 0);
    const bool expected =
        p_left.z() >= 0.3 && p_left.z() <= 5.0 && in_image(stereo.camera, p_left) && in_image(stereo.camera, p_right);
    ASSERT_EQ(CameraView(camera, pose).contains(p), expected) << p.transpose();
    inside += expected ? 1 : 0;
  }
  EXPECT_GT(inside, 500);
}

TEST(LevelCamera, StandsOffAsTheVerticalViewDemands) {
  // 1.6 m above the camera, slope of the upper border 256 / 377: 1.6 * 377 / 256 = 2.35625.
  EXPECT_NEAR(rig_camera().stand_off_for_height_m(1.6), 2.35625, 1e-9);
  EXPECT_NEAR(rig_camera().stand_off_for_height_m(-0.4), 0.4 * 377 / 256, 1e-9);
}

TEST(LevelCamera, PutsTheBodyBehindTheMiddleOfThePair) {
  const LevelCamera camera = rig_camera();
  const Pose2 body = camera.body_at({2.0, 1.0}, std::numbers::pi / 2);
  EXPECT_NEAR(body.x_m, 2.0, 1e-12);
  EXPECT_NEAR(body.y_m, 0.8, 1e-12);
  const Eigen::Vector3d left = camera.position_m(body);
  EXPECT_LT((left - Eigen::Vector3d(2.0 - 0.13, 1.0, 0.4)).norm(), 1e-12);
}

TEST(LevelCamera, RefusesACameraThatDoesNotLookAhead) {
  Pose tilted = T_body_rig();
  tilted.linear() = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()) * tilted.linear();
  EXPECT_THROW((void)make_level_camera(rig_stereo(), tilted, 0.3, 5.0), InputError);
  EXPECT_THROW((void)make_level_camera(rig_stereo(), T_body_rig(), 5.0, 0.3), InputError);
}

}  // namespace
}  // namespace arpent::planning
