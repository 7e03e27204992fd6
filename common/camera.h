// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Camera models: the ideal pinhole of a rectified image, a raw camera with lens distortion, and the stereo pair of
// either. Pixel coordinates have the centre of the top-left pixel at (0, 0).
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "common/geometry.h"

namespace arpent {

/// Ideal pinhole: u = fx X/Z + cx, v = fy Y/Z + cy.
struct PinholeCamera {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;

  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& p_cam_m) const {
    return {fx_px * p_cam_m.x() / p_cam_m.z() + cx_px, fy_px * p_cam_m.y() / p_cam_m.z() + cy_px};
  }
  /// The point at depth `z_m` (along the optical axis) seen at pixel (u, v).
  [[nodiscard]] Eigen::Vector3d unproject(double u_px, double v_px, double z_m) const {
    return {(u_px - cx_px) / fx_px * z_m, (v_px - cy_px) / fy_px * z_m, z_m};
  }
  bool operator==(const PinholeCamera&) const = default;
};

/// A rectified stereo camera: both images share `camera`, and a point at depth z has u_left - u_right = baseline_m * fx
/// / z (thesis App. A.2.2, eq. A.12 with d = u_left - u_right).
struct RectifiedStereo {
  PinholeCamera camera;
  double baseline_m = 0;
  bool operator==(const RectifiedStereo&) const = default;
};

enum class DistortionModel { kNone, kRadialTangential, kEquidistant };

/// A raw camera: pinhole with lens distortion. Coefficients: radial-tangential (k1, k2, p1, p2, k3), equidistant
/// (k1..k4).
struct RawCamera {
  PinholeCamera pinhole;
  DistortionModel distortion = DistortionModel::kNone;
  std::array<double, 5> coefficients{};
};

/// A raw stereo camera on a body. `T_right_left` maps left-camera coordinates into the right camera's.
struct StereoCalibration {
  RawCamera left;
  RawCamera right;
  Pose T_right_left = Pose::Identity();
  Pose T_body_left = Pose::Identity();
};

/// Every reason why a calibration cannot be used, one line each; empty if it is sound. Checks: finite, positive focal
/// lengths, principal point inside the image, equal sizes, rigid rotation, right camera to the right of the left one.
[[nodiscard]] std::vector<std::string> find_faults(const StereoCalibration& calibration);
[[nodiscard]] std::vector<std::string> find_faults(const RectifiedStereo& stereo);

}  // namespace arpent
