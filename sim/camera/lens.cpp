// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/lens.h"

#include <Eigen/LU>
#include <cmath>

namespace arpent::sim {
namespace {

Eigen::Vector2d radial_tangential(const std::array<double, 5>& k, const Eigen::Vector2d& p) {
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

Eigen::Vector2d equidistant(const std::array<double, 5>& k, const Eigen::Vector2d& p) {
  const double r = p.norm();
  if (r < 1e-12) return p;
  const double theta = std::atan(r), t2 = theta * theta;
  return p * (theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3])))) / r);
}

}  // namespace

Eigen::Vector2d distort(const RawCamera& camera, const Eigen::Vector2d& ideal) {
  switch (camera.distortion) {
    case DistortionModel::kRadialTangential:
      return radial_tangential(camera.coefficients, ideal);
    case DistortionModel::kEquidistant:
      return equidistant(camera.coefficients, ideal);
    case DistortionModel::kNone:
      break;
  }
  return ideal;
}

Eigen::Vector2d undistort(const RawCamera& camera, const Eigen::Vector2d& distorted) {
  if (camera.distortion == DistortionModel::kNone) return distorted;
  Eigen::Vector2d p = distorted;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d error = distort(camera, p) - distorted;
    if (error.norm() < 1e-12) break;
    constexpr double kStep = 1e-6;
    Eigen::Matrix2d jacobian;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
      jacobian.col(axis) = (distort(camera, p + step) - distort(camera, p - step)) / (2 * kStep);
    }
    p -= jacobian.inverse() * error;
  }
  return p;
}

}  // namespace arpent::sim
