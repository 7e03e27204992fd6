// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/wire.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "perception/odometry/wire.h"

namespace arpent::fusion {
namespace {

constexpr char kWorldFrame[] = "world";
constexpr char kOdomFrame[] = "odom";
constexpr char kBodyFrame[] = "body";

// Nothing of ours is farther, faster or less certain than this; what is would only break arithmetic.
constexpr double kMaxPositionM = 1e6;
constexpr double kMaxSpeedMps = 100;
constexpr double kMaxRateRadps = 100;
constexpr double kMaxVariance = 1e6;

using Wire3 = const double (&)[3];
using Wire4 = const double (&)[4];
using Wire66 = const double (&)[6][6];

/// NaN is not within.
bool within(double value, double most) {
  return std::abs(value) <= most;
}

std::optional<Pose> read_pose(Wire3 position_m, Wire4 q) {
  const auto pose = make_pose(Eigen::Map<const Eigen::Vector3d>(position_m), {q[0], q[1], q[2], q[3]});
  return pose && within(pose->translation().lpNorm<Eigen::Infinity>(), kMaxPositionM) ? pose : std::nullopt;
}

std::optional<Matrix6d> read_covariance(Wire66 from) {
  const Matrix6d m = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(&from[0][0]);
  if (!m.allFinite() || m.cwiseAbs().maxCoeff() > kMaxVariance) return std::nullopt;
  const double scale = std::max(m.cwiseAbs().maxCoeff(), 1e-30);
  if ((m - m.transpose()).cwiseAbs().maxCoeff() > 1e-6 * scale) return std::nullopt;
  const Matrix6d symmetric = 0.5 * (m + m.transpose());
  if (Eigen::SelfAdjointEigenSolver<Matrix6d>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()(0) < -1e-9 * scale) {
    return std::nullopt;
  }
  return symmetric;
}

constexpr char kBadPose[] = "the pose is not a rigid motion nearby";
constexpr char kBadCovariance[] = "a covariance is not one";

}  // namespace

Result<WheelReading> from_wire(const wheel_state_t& message) {
  if (!within(message.left_m, kMaxPositionM) || !within(message.right_m, kMaxPositionM)) {
    return Fault{"an odometer is not a way"};
  }
  if (!within(message.commanded_speed_mps, kMaxSpeedMps) || !within(message.commanded_turn_rate_radps, kMaxRateRadps)) {
    return Fault{"the command is not a motion"};
  }
  WheelReading reading;
  reading.stamp = from_utime(message.utime);
  reading.left_m = message.left_m;
  reading.right_m = message.right_m;
  reading.commanded = {message.commanded_speed_mps, message.commanded_turn_rate_radps};
  reading.usable = message.heard != 0 && message.fault.empty();
  return reading;
}

Result<GyroReading> from_wire(const imu_t& message) {
  for (const double rate : message.angular_velocity_radps) {
    if (!within(rate, kMaxRateRadps)) return Fault{"an angular velocity is none of a robot"};
  }
  return GyroReading{from_utime(message.utime), message.angular_velocity_radps[2]};
}

Result<OdometryReading> from_wire(const odometry_t& message) {
  const auto odometry = odometry::from_wire(message);
  if (!odometry) return Fault{odometry.fault()};
  const auto covariance = read_covariance(message.covariance);
  const auto step_covariance = read_covariance(message.step_covariance);
  if (!covariance || !step_covariance) return Fault{kBadCovariance};
  if (!read_pose(message.position_m, message.orientation_wxyz)) return Fault{kBadPose};
  OdometryReading reading;
  reading.stamp = odometry->stamp;
  reading.sequence = odometry->sequence;
  reading.T_odom_body = odometry->T_odom_body;
  reading.covariance = *covariance;
  reading.step_covariance = *step_covariance;
  reading.usable = odometry->status != odometry::Status::kLost;
  // Odometry that gets lost starts anew at a keyframe; a pair that it did not even look at is none.
  reading.anchored = reading.usable || odometry->keyframe;
  reading.reason = odometry->reason;
  return reading;
}

Result<WorldReading> from_wire(const tag_observation_t& message) {
  if (message.accepted == 0) return Fault{"not accepted: " + message.reason};
  if (message.frame != kWorldFrame || message.child_frame != kBodyFrame) return Fault{"frames are not world and body"};
  const auto pose = read_pose(message.position_m, message.orientation_wxyz);
  if (!pose) return Fault{kBadPose};
  const auto covariance = read_covariance(message.covariance);
  if (!covariance) return Fault{kBadCovariance};
  return WorldReading{from_utime(message.utime), *pose, *covariance};
}

Result<AlignmentReading> from_wire(const frame_alignment_t& message) {
  if (message.frame != kWorldFrame || message.child_frame != kOdomFrame) return Fault{"frames are not world and odom"};
  const auto pose = read_pose(message.position_m, message.orientation_wxyz);
  if (!pose) return Fault{kBadPose};
  const auto covariance = read_covariance(message.covariance);
  if (!covariance) return Fault{kBadCovariance};
  return AlignmentReading{from_utime(message.utime), *pose, *covariance};
}

body_pose_t to_wire(const FusedPose& pose, std::int64_t sequence) {
  body_pose_t message{};
  message.utime = to_utime(pose.stamp);
  message.sequence = sequence;
  message.frame = pose.frame == Frame::kWorld ? kWorldFrame : kOdomFrame;
  message.child_frame = kBodyFrame;
  const Eigen::Quaterniond q = canonical_quaternion(pose.T_frame_body.linear());
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(wxyz, wxyz + 4, message.orientation_wxyz);
  for (int i = 0; i < 3; ++i) message.position_m[i] = pose.T_frame_body.translation()[i];
  message.velocity_mps[0] = pose.twist.speed_mps;
  message.angular_velocity_radps[2] = pose.twist.turn_rate_radps;
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(&message.covariance[0][0]) = pose.covariance;
  message.status = static_cast<std::int8_t>(pose.status);
  message.reason = pose.reason;
  message.odometry_utime = pose.odometry_stamp ? to_utime(*pose.odometry_stamp) : 0;
  return message;
}

Result<FusedPose> from_wire(const body_pose_t& message) {
  const bool world = message.frame == kWorldFrame;
  if ((!world && message.frame != kOdomFrame) || message.child_frame != kBodyFrame) {
    return Fault{"frames are not world or odom and body"};
  }
  if (message.status < body_pose_t::STATUS_OK || message.status > body_pose_t::STATUS_LOST) {
    return Fault{"unknown status"};
  }
  const auto pose = read_pose(message.position_m, message.orientation_wxyz);
  if (!pose) return Fault{kBadPose};
  const auto covariance = read_covariance(message.covariance);
  if (!covariance) return Fault{kBadCovariance};
  if (!within(message.velocity_mps[0], kMaxSpeedMps) || !within(message.angular_velocity_radps[2], kMaxRateRadps)) {
    return Fault{"the velocity is none of a robot"};
  }
  FusedPose fused;
  fused.stamp = from_utime(message.utime);
  fused.frame = world ? Frame::kWorld : Frame::kOdom;
  fused.T_frame_body = *pose;
  fused.twist = {message.velocity_mps[0], message.angular_velocity_radps[2]};
  fused.covariance = *covariance;
  fused.status = static_cast<Status>(message.status);
  fused.reason = message.reason;
  if (message.odometry_utime != 0) fused.odometry_stamp = from_utime(message.odometry_utime);
  return fused;
}

}  // namespace arpent::fusion
