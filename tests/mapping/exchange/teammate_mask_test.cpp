// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/teammate_mask.h"

#include <gtest/gtest.h>

namespace arpent::mapping {
namespace {

const PinholeCamera kCamera{160, 128, 94, 94, 79.5, 63.5};

Pose camera_at(const Pose2& body) {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Pose T_body_cam = Pose::Identity();
  T_body_cam.linear() = R;
  T_body_cam.translation() = Eigen::Vector3d(0, 0, 0.4);
  return body.to_pose() * T_body_cam;
}

stereo::DepthMap far_wall() {
  return {kCamera, cv::Mat1f(kCamera.height_px, kCamera.width_px, 4.0F),
          cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.02F)};
}

TEST(TeammateMask, EveryPixelWhoseRayMeetsTheBoxIsMaskedAndNoOther) {
  const Pose T_map_cam = camera_at({0.3, -0.2, 0.4});
  const TeammateMaskParams params;
  const SeenTeammate mate{{2.0, 0.5, 1.1}, 0.05};
  stereo::DepthMap depth = far_wall();
  const int masked = mask_teammates(depth, T_map_cam, {&mate, 1}, params);
  // The twin: step along each ray and ask whether the point lies in the grown box.
  const double grow = params.margin_m + mate.uncertainty_m;
  const Pose T_mate_cam = mate.body.to_pose().inverse() * T_map_cam;
  int wrong = 0, inside = 0;
  for (int v = 0; v < kCamera.height_px; ++v) {
    for (int u = 0; u < kCamera.width_px; ++u) {
      bool meets = false;
      for (double z = 0.2; z < 5 && !meets; z += 0.01) {
        const Eigen::Vector3d p = T_mate_cam * kCamera.unproject(u, v, z);
        meets = std::abs(p.x()) <= params.half_length_m + grow && std::abs(p.y()) <= params.half_width_m + grow &&
                p.z() >= 0 && p.z() <= params.height_m + grow;
      }
      inside += meets ? 1 : 0;
      wrong += meets != (depth.depth_m(v, u) == 0) ? 1 : 0;
      EXPECT_EQ(depth.depth_m(v, u) == 0, depth.sigma_m(v, u) == 0);
    }
  }
  EXPECT_GT(inside, 500);
  EXPECT_LT(wrong, inside / 20) << "the outline's pixels may differ by rounding";
  EXPECT_NEAR(masked, inside, inside / 20);
}

TEST(TeammateMask, WhatStandsBehindOrBesideTheCameraMasksNothing) {
  const Pose T_map_cam = camera_at({});
  for (const Pose2& body : {Pose2{-2, 0, 0.3}, Pose2{0, 2.5, 0}}) {
    stereo::DepthMap depth = far_wall();
    const SeenTeammate mate{body, 0};
    EXPECT_EQ(mask_teammates(depth, T_map_cam, {&mate, 1}, {}), 0);
  }
}

TEST(TeammateMask, ATeammateWhoseBoxCrossesTheImagePlaneMasksItsSideOnly) {
  stereo::DepthMap depth = far_wall();
  const SeenTeammate mate{{0.1, 0.6, 0}, 0};  // to the left, partly before the camera
  EXPECT_GT(mask_teammates(depth, camera_at({}), {&mate, 1}, {}), 0);
  EXPECT_EQ(depth.depth_m(90, 0), 0);
  EXPECT_EQ(depth.depth_m(90, 150), 4.0F);
}

}  // namespace
}  // namespace arpent::mapping
