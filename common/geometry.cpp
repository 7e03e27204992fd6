// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/geometry.h"

#include <cmath>

namespace arpent {

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_rad) {
  const double angle = rotation_rad.norm();
  if (angle < 1e-9) {
    Eigen::Quaterniond q(1.0, 0.5 * rotation_rad.x(), 0.5 * rotation_rad.y(), 0.5 * rotation_rad.z());
    return q.normalized().toRotationMatrix();
  }
  return Eigen::AngleAxisd(angle, rotation_rad / angle).toRotationMatrix();
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  const Eigen::Quaterniond q = canonical_quaternion(R);
  const double s = q.vec().norm();
  if (s < 1e-9) return 2.0 * q.vec();
  return 2.0 * std::atan2(s, q.w()) / s * q.vec();
}

Pose retract(const Pose& T_a_b, const Vector6d& delta_b) {
  Pose step = Pose::Identity();
  step.linear() = so3_exp(delta_b.tail<3>());
  step.translation() = delta_b.head<3>();
  return T_a_b * step;
}

Vector6d local(const Pose& T_a_b, const Pose& T_a_c) {
  const Pose T_b_c = T_a_b.inverse() * T_a_c;
  Vector6d delta;
  delta << T_b_c.translation(), so3_log(T_b_c.linear());
  return delta;
}

Matrix6d adjoint(const Pose& T_a_b) {
  Eigen::Matrix3d skew;
  const Eigen::Vector3d t = T_a_b.translation();
  skew << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Matrix6d Ad = Matrix6d::Zero();
  Ad.topLeftCorner<3, 3>() = T_a_b.linear();
  Ad.bottomRightCorner<3, 3>() = T_a_b.linear();
  Ad.topRightCorner<3, 3>() = skew * T_a_b.linear();
  return Ad;
}

Pose interpolate(const Pose& from, const Pose& to, double s) {
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(from.linear()).slerp(s, Eigen::Quaterniond(to.linear())).normalized().toRotationMatrix();
  pose.translation() = (1.0 - s) * from.translation() + s * to.translation();
  return pose;
}

std::optional<Pose> make_pose(const Eigen::Vector3d& translation_m, const Eigen::Quaterniond& q) {
  if (!translation_m.allFinite() || !q.coeffs().allFinite() || std::abs(q.norm() - 1.0) > 1e-3) return std::nullopt;
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = translation_m;
  return pose;
}

Eigen::Quaterniond canonical_quaternion(const Eigen::Matrix3d& R) {
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  return q;
}

Eigen::Matrix3d R_body_from_camera_axes() {
  Eigen::Matrix3d R;
  R << 0, 0, 1,  //
      -1, 0, 0,  //
      0, -1, 0;
  return R;
}

}  // namespace arpent
