// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The measurement model of a rectified stereo camera: a point is seen at (u_left, v, u_right). Residuals live in these
// three pixel coordinates, not in metres: depth from disparity is biased for far points, pixels are not.
#pragma once

#include <Eigen/Core>

#include "common/camera.h"
#include "common/geometry.h"

namespace arpent::odometry {

using Vector3d = Eigen::Vector3d;
using Matrix3d = Eigen::Matrix3d;

/// What every disparity is short of: a small angle between the cameras that the calibration does not know, or what the
/// images make of it, shifts all disparities alike, and with them the scale of the motion. Structure from motion tells
/// it from true depth: near and far points of one rigid scene do not agree otherwise.
struct DisparityOffset {
  double px = 0;  ///< u_right of a point is its measured one minus this
  double variance_px2 = 0;
};

/// (u_left, v, u_right) of a point [m] in the left camera's frame, z > 0.
[[nodiscard]] inline Vector3d project(const RectifiedStereo& stereo, const Vector3d& p_cam_m) {
  const PinholeCamera& c = stereo.camera;
  const double iz = 1.0 / p_cam_m.z();
  return {c.fx_px * p_cam_m.x() * iz + c.cx_px, c.fy_px * p_cam_m.y() * iz + c.cy_px,
          c.fx_px * (p_cam_m.x() - stereo.baseline_m) * iz + c.cx_px};
}

/// Derivative of project() by the point.
[[nodiscard]] inline Matrix3d project_jacobian(const RectifiedStereo& stereo, const Vector3d& p_cam_m) {
  const PinholeCamera& c = stereo.camera;
  const double iz = 1.0 / p_cam_m.z();
  const double fx_z = c.fx_px * iz;
  const double fy_z = c.fy_px * iz;
  Matrix3d J;
  J << fx_z, 0, -fx_z * p_cam_m.x() * iz,  //
      0, fy_z, -fy_z * p_cam_m.y() * iz,   //
      fx_z, 0, -fx_z * (p_cam_m.x() - stereo.baseline_m) * iz;
  return J;
}

/// The point seen at (u_left, v, u_right), u_left > u_right.
[[nodiscard]] inline Vector3d triangulate(const RectifiedStereo& stereo, const Vector3d& z_px) {
  const double depth_m = stereo.baseline_m * stereo.camera.fx_px / (z_px.x() - z_px.z());
  return stereo.camera.unproject(z_px.x(), z_px.y(), depth_m);
}

/// Derivative of `T_odom_cam^-1 p_odom` by the tangent of retract(T_odom_cam, delta), where p_cam is its value.
[[nodiscard]] inline Eigen::Matrix<double, 3, 6> point_by_pose_jacobian(const Vector3d& p_cam_m) {
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>() = -Matrix3d::Identity();
  J.rightCols<3>() << 0, -p_cam_m.z(), p_cam_m.y(),  //
      p_cam_m.z(), 0, -p_cam_m.x(),                  //
      -p_cam_m.y(), p_cam_m.x(), 0;
  return J;
}

}  // namespace arpent::odometry
