// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A pose on the ground: where a wheeled robot stands and where it looks.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "common/geometry.h"

namespace arpent {

/// The same angle in [-pi, pi].
[[nodiscard]] inline double wrap_angle(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

struct Pose2 {
  double x_m = 0;
  double y_m = 0;
  double yaw_rad = 0;

  [[nodiscard]] Eigen::Vector2d position_m() const { return {x_m, y_m}; }
  /// At height 0, level.
  [[nodiscard]] Pose to_pose() const {
    return Eigen::Translation3d(x_m, y_m, 0) * Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ());
  }
  friend bool operator==(const Pose2&, const Pose2&) = default;
};

/// Where a pose stands on the ground; roll and pitch are left out.
[[nodiscard]] inline Pose2 to_pose2(const Pose& T) {
  return {T.translation().x(), T.translation().y(), std::atan2(T.linear()(1, 0), T.linear()(0, 0))};
}

}  // namespace arpent
