// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The lens models that are estimated, written for doubles and for Ceres' dual numbers alike: pinhole with
// radial-tangential (Brown; OpenCV's signs) or equidistant distortion (Kannala and Brandt 2006), four coefficients
// each.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "common/camera.h"

namespace arpent::calib {

/// fx, fy, cx, cy [px], then k1, k2, p1, p2 or k1..k4.
inline constexpr int kLensParameters = 8;
using LensParameters = std::array<double, kLensParameters>;
inline constexpr const char* kRadialTangentialNames[] = {"fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2"};
inline constexpr const char* kEquidistantNames[] = {"fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "k3", "k4"};

/// Pixel of a point in camera axes. False if the point is not before the camera.
template <class T>
bool project(DistortionModel model, const T* lens, const T* p_cam, T* px) {
  using std::atan2;
  using std::sqrt;
  if (!(p_cam[2] > T(1e-6))) return false;
  const T x = p_cam[0] / p_cam[2], y = p_cam[1] / p_cam[2], r2 = x * x + y * y;
  T xd = x, yd = y;
  if (model == DistortionModel::kRadialTangential) {
    const T radial = T(1) + r2 * (lens[4] + r2 * lens[5]);
    xd = x * radial + T(2) * lens[6] * x * y + lens[7] * (r2 + T(2) * x * x);
    yd = y * radial + lens[6] * (r2 + T(2) * y * y) + T(2) * lens[7] * x * y;
  } else if (model == DistortionModel::kEquidistant && r2 > T(1e-12)) {
    const T r = sqrt(r2), theta = atan2(r, T(1)), t2 = theta * theta;
    const T scale = theta * (T(1) + t2 * (lens[4] + t2 * (lens[5] + t2 * (lens[6] + t2 * lens[7])))) / r;
    xd = x * scale;
    yd = y * scale;
  }
  px[0] = lens[0] * xd + lens[2];
  px[1] = lens[1] * yd + lens[3];
  return true;
}

[[nodiscard]] LensParameters to_parameters(const RawCamera& camera);
/// `camera` with the given parameters.
[[nodiscard]] RawCamera with_parameters(RawCamera camera, const LensParameters& lens);

/// Ideal plane coordinates (X/Z, Y/Z) seen at a pixel, by Newton's method; nullopt where the model has no inverse.
[[nodiscard]] std::optional<Eigen::Vector2d> unproject(const RawCamera& camera, const Eigen::Vector2d& px);

}  // namespace arpent::calib
