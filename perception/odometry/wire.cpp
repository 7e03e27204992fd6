// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/wire.h"

#include <cmath>

namespace arpent::odometry {
namespace {

constexpr char kOdomFrame[] = "odom";
constexpr char kBodyFrame[] = "body";

void copy_matrix(const Matrix6d& from, double (&to)[6][6]) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) to[r][c] = from(r, c);
  }
}

Matrix6d read_matrix(const double (&from)[6][6]) {
  Matrix6d matrix;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) matrix(r, c) = from[r][c];
  }
  return matrix;
}

bool is_covariance(const Matrix6d& m) {
  return m.allFinite() && (m.diagonal().array() >= 0).all();
}

}  // namespace

odometry_t to_wire(const BodyOdometry& odometry) {
  odometry_t message{};
  message.utime = to_utime(odometry.stamp);
  message.sequence = odometry.sequence;
  message.frame = kOdomFrame;
  message.child_frame = kBodyFrame;
  const Eigen::Quaterniond q = canonical_quaternion(odometry.T_odom_body.linear());
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(wxyz, wxyz + 4, message.orientation_wxyz);
  for (int i = 0; i < 3; ++i) {
    message.position_m[i] = odometry.T_odom_body.translation()[i];
    message.velocity_mps[i] = odometry.velocity_body[i];
    message.angular_velocity_radps[i] = odometry.velocity_body[3 + i];
  }
  copy_matrix(odometry.covariance, message.covariance);
  copy_matrix(odometry.step_covariance, message.step_covariance);
  message.status = static_cast<std::int8_t>(odometry.status);
  message.reason = odometry.reason;
  message.tracked = odometry.tracked;
  message.inliers = odometry.inliers;
  message.keyframe = odometry.keyframe ? 1 : 0;
  return message;
}

Result<BodyOdometry> from_wire(const odometry_t& message) {
  if (message.frame != kOdomFrame || message.child_frame != kBodyFrame) return Fault{"frames are not odom and body"};
  if (message.status < odometry_t::STATUS_OK || message.status > odometry_t::STATUS_LOST)
    return Fault{"unknown status"};
  const double* q = message.orientation_wxyz;
  const auto pose = make_pose(Eigen::Map<const Eigen::Vector3d>(message.position_m), {q[0], q[1], q[2], q[3]});
  if (!pose) return Fault{"the pose is not a rigid motion"};
  BodyOdometry odometry;
  odometry.stamp = from_utime(message.utime);
  odometry.sequence = message.sequence;
  odometry.T_odom_body = *pose;
  odometry.velocity_body << Eigen::Map<const Eigen::Vector3d>(message.velocity_mps),
      Eigen::Map<const Eigen::Vector3d>(message.angular_velocity_radps);
  odometry.covariance = read_matrix(message.covariance);
  odometry.step_covariance = read_matrix(message.step_covariance);
  if (!odometry.velocity_body.allFinite()) return Fault{"the velocity is not finite"};
  if (!is_covariance(odometry.covariance) || !is_covariance(odometry.step_covariance)) {
    return Fault{"a covariance is not finite or has a negative variance"};
  }
  odometry.status = static_cast<Status>(message.status);
  odometry.reason = message.reason;
  odometry.tracked = message.tracked;
  odometry.inliers = message.inliers;
  odometry.keyframe = message.keyframe != 0;
  return odometry;
}

BodyOdometry to_body(const Estimate& estimate, std::int64_t sequence, const Pose& T_body_cam,
                     const BodyOdometry* previous) {
  BodyOdometry body;
  body.stamp = estimate.stamp;
  body.sequence = sequence;
  body.T_odom_body = T_body_cam * estimate.T_odom_cam * T_body_cam.inverse();
  const Matrix6d Ad = adjoint(T_body_cam);
  body.covariance = Ad * estimate.covariance * Ad.transpose();
  body.step_covariance = Ad * estimate.step_covariance * Ad.transpose();
  body.status = estimate.status;
  body.reason = estimate.reason;
  body.tracked = estimate.tracked;
  body.inliers = estimate.inliers;
  body.keyframe = estimate.keyframe;
  if (previous != nullptr && estimate.stamp > previous->stamp) {
    body.velocity_body = local(previous->T_odom_body, body.T_odom_body) / to_seconds(estimate.stamp - previous->stamp);
  }
  return body;
}

}  // namespace arpent::odometry
