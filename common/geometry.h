// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rigid motions. `T_a_b` maps coordinates in frame b to frame a, so that inner names cancel:
// `T_world_cam = T_world_body * T_body_cam`. Tangent vectors are (translation, rotation), metres and radians.
#pragma once

#include <Eigen/Geometry>
#include <optional>

namespace arpent {

using Pose = Eigen::Isometry3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Exponential map of so(3) (Rodrigues), exact to second order near zero.
[[nodiscard]] Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_rad);
/// Logarithm of a rotation, angle in [0, pi].
[[nodiscard]] Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);

/// Retraction used by every solver of the house: `T * [so3_exp(w), v]`, with delta = (v, w) in the *right* (inner)
/// frame.
[[nodiscard]] Pose retract(const Pose& T_a_b, const Vector6d& delta_b);
/// Inverse of retract: `local(T, retract(T, d)) == d` for |rotation| < pi.
[[nodiscard]] Vector6d local(const Pose& T_a_b, const Pose& T_a_c);

/// Adjoint of T_a_b for tangents (translation, rotation): the same small motion seen from a instead of b, so that
/// `T_a_b * exp(d) = exp(Ad d) * T_a_b` to first order. A covariance moves by `Ad C Ad^T`.
[[nodiscard]] Matrix6d adjoint(const Pose& T_a_b);

/// The pose a share `s` in [0, 1] of the way from `from` to `to`: linear translation, spherical rotation.
[[nodiscard]] Pose interpolate(const Pose& from, const Pose& to, double s);

/// Pose from translation [m] and unit quaternion; nullopt if anything is not finite or |q| is off 1 by more than 1e-3.
[[nodiscard]] std::optional<Pose> make_pose(const Eigen::Vector3d& translation_m, const Eigen::Quaterniond& q);
/// The rotation as a quaternion with w >= 0, so that equal poses have equal numbers.
[[nodiscard]] Eigen::Quaterniond canonical_quaternion(const Eigen::Matrix3d& R);

/// Rotation that turns camera axes (x right, y down, z forward) into body axes (x forward, y left, z up).
[[nodiscard]] Eigen::Matrix3d R_body_from_camera_axes();

}  // namespace arpent
