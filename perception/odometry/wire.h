// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of odometry: odometry_t.
#pragma once

#include <arpent/odometry_t.hpp>
#include <cstdint>
#include <string>

#include "common/geometry.h"
#include "common/result.h"
#include "common/time.h"
#include "perception/odometry/odometry.h"

namespace arpent::odometry {

/// An odometry message as others use it. Frames: odom (the body at the first pair) and body.
struct BodyOdometry {
  Time stamp;
  std::int64_t sequence = 0;
  Pose T_odom_body = Pose::Identity();
  Vector6d velocity_body = Vector6d::Zero();  ///< (linear [m/s], angular [rad/s]) in body axes, mean over the last step
  Matrix6d covariance = Matrix6d::Zero();     ///< accumulated, (translation, rotation) in body axes
  Matrix6d step_covariance = Matrix6d::Zero();
  Status status = Status::kLost;
  std::string reason;
  int tracked = 0;
  int inliers = 0;
  bool keyframe = false;
};

[[nodiscard]] odometry_t to_wire(const BodyOdometry& odometry);
/// Checks frames, finiteness, the unit quaternion, the status' range and non-negative variances.
[[nodiscard]] Result<BodyOdometry> from_wire(const odometry_t& message);

/// Moves a left-camera estimate to the body: T_odom_body = T_body_cam T_odomcam_cam T_body_cam^-1, covariances by the
/// adjoint. `previous` (nullptr for the first) gives the velocity.
[[nodiscard]] BodyOdometry to_body(const Estimate& estimate, std::int64_t sequence, const Pose& T_body_cam,
                                   const BodyOdometry* previous);

}  // namespace arpent::odometry
