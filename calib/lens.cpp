// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/lens.h"

#include <Eigen/LU>

namespace arpent::calib {

LensParameters to_parameters(const RawCamera& camera) {
  const PinholeCamera& p = camera.pinhole;
  const auto& k = camera.coefficients;
  return {p.fx_px, p.fy_px, p.cx_px, p.cy_px, k[0], k[1], k[2], k[3]};
}

RawCamera with_parameters(RawCamera camera, const LensParameters& lens) {
  camera.pinhole.fx_px = lens[0];
  camera.pinhole.fy_px = lens[1];
  camera.pinhole.cx_px = lens[2];
  camera.pinhole.cy_px = lens[3];
  camera.coefficients = {lens[4], lens[5], lens[6], lens[7], 0};
  return camera;
}

std::optional<Eigen::Vector2d> unproject(const RawCamera& camera, const Eigen::Vector2d& px) {
  constexpr double kStep = 1e-6, kDonePx = 1e-8;
  const LensParameters lens = to_parameters(camera);
  const auto pixel = [&](const Eigen::Vector2d& plane) {
    const Eigen::Vector3d p(plane.x(), plane.y(), 1);
    Eigen::Vector2d seen;
    project(camera.distortion, lens.data(), p.data(), seen.data());
    return seen;
  };
  Eigen::Vector2d plane((px.x() - lens[2]) / lens[0], (px.y() - lens[3]) / lens[1]);
  if (camera.distortion == DistortionModel::kEquidistant) {
    const double theta = std::min(plane.norm(), 1.5);
    if (theta > 1e-9) plane *= std::tan(theta) / plane.norm();
  }
  for (int i = 0; i < 50; ++i) {
    const Eigen::Vector2d error = pixel(plane) - px;
    if (!error.allFinite()) return std::nullopt;
    if (error.norm() < kDonePx) return plane;
    Eigen::Matrix2d J;
    J.col(0) = (pixel(plane + Eigen::Vector2d(kStep, 0)) - pixel(plane - Eigen::Vector2d(kStep, 0))) / (2 * kStep);
    J.col(1) = (pixel(plane + Eigen::Vector2d(0, kStep)) - pixel(plane - Eigen::Vector2d(0, kStep))) / (2 * kStep);
    if (!(J.determinant() > 0)) return std::nullopt;
    plane -= J.inverse() * error;
  }
  return std::nullopt;
}

}  // namespace arpent::calib
