// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/level_camera.h"

#include <cmath>

#include "common/error.h"

namespace arpent::planning {

Eigen::Vector3d LevelCamera::position_m(const Pose2& pose) const {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  return {pose.x_m + c * p_body_m.x() - s * p_body_m.y(), pose.y_m + s * p_body_m.x() + c * p_body_m.y(), p_body_m.z()};
}

Pose2 LevelCamera::body_at(const Eigen::Vector2d& centre_m, double yaw_rad) const {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  const Eigen::Vector2d offset = centre_body_m();
  return {centre_m.x() - (c * offset.x() - s * offset.y()), centre_m.y() - (s * offset.x() + c * offset.y()),
          wrap_angle(yaw_rad)};
}

double LevelCamera::stand_off_for_height_m(double above_camera_m) const {
  return above_camera_m >= 0 ? above_camera_m / up_slope : -above_camera_m / down_slope;
}

CameraView::CameraView(const LevelCamera& camera, const Pose2& pose)
    : camera_(camera), position_m_(camera.position_m(pose)), forward_(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad)) {}

LevelCamera make_level_camera(const RectifiedStereo& stereo, const Pose& T_body_cam, double min_range_m,
                              double max_range_m) {
  constexpr double kLevelRad = 0.035;
  const auto faults = find_faults(stereo);
  if (!faults.empty()) throw InputError("camera for viewpoints: " + faults.front());
  const double off_rad = so3_log(R_body_from_camera_axes().transpose() * T_body_cam.linear()).norm();
  if (!(off_rad < kLevelRad)) throw InputError("T_body_cam: viewpoints need a level camera that looks along x");
  if (!(min_range_m > 0 && min_range_m < max_range_m && std::isfinite(max_range_m))) {
    throw InputError("camera for viewpoints: range must be 0 < min_range_m < max_range_m");
  }
  const PinholeCamera& c = stereo.camera;
  return {.left_slope = (c.cx_px + 0.5) / c.fx_px,
          .right_slope = (c.width_px - 0.5 - c.cx_px) / c.fx_px,
          .up_slope = (c.cy_px + 0.5) / c.fy_px,
          .down_slope = (c.height_px - 0.5 - c.cy_px) / c.fy_px,
          .baseline_m = stereo.baseline_m,
          .min_range_m = min_range_m,
          .max_range_m = max_range_m,
          .p_body_m = T_body_cam.translation()};
}

}  // namespace arpent::planning
