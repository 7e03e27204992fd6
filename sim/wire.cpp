// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/wire.h"

#include <cmath>

#include "common/image_codec.h"

namespace arpent::sim {
namespace {

constexpr int kPlausibleTracks = 200;

template <class Message>
void set_pose(Message& message, const Pose& T) {
  const Eigen::Quaterniond q = canonical_quaternion(T.linear());
  Eigen::Map<Eigen::Vector3d>(message.position_m) = T.translation();
  const double wxyz[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(std::begin(wxyz), std::end(wxyz), std::begin(message.orientation_wxyz));
}

void set_covariance(double (&to)[6][6], const Matrix6d& P) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) to[r][c] = P(r, c);
  }
}

/// In units of `unit`, 0 for what is missing or does not fit.
image_t quantise(const cv::Mat1f& values, double unit) {
  cv::Mat1w units;
  values.convertTo(units, CV_16U, 1 / unit);
  return encode_image(units);
}

}  // namespace

stereo_images_t to_wire(Time stamp, std::int64_t sequence, const camera::ExposureSetting& exposure,
                        const cv::Mat1b& left, const cv::Mat1b& right) {
  stereo_images_t message{};
  message.utime = to_utime(stamp);
  message.sequence = sequence;
  message.exposure_us = exposure.exposure_us;
  message.gain_db = static_cast<float>(exposure.gain_db);
  message.left = encode_image(left);
  message.right = encode_image(right);
  return message;
}

imu_t to_wire(Time stamp, std::int64_t sequence, const ImuReading& reading) {
  imu_t message{};
  message.utime = to_utime(stamp);
  message.sequence = sequence;
  Eigen::Map<Eigen::Vector3d>(message.angular_velocity_radps) = reading.angular_velocity_radps;
  Eigen::Map<Eigen::Vector3d>(message.acceleration_mps2) = reading.acceleration_mps2;
  return message;
}

pose_t to_wire(Time stamp, const Pose2& pose) {
  pose_t message{};
  message.utime = to_utime(stamp);
  message.frame = "world";
  message.child_frame = "body";
  set_pose(message, pose.to_pose());
  return message;
}

depth_t to_wire(Time stamp, std::int64_t sequence, const PinholeCamera& camera, const cv::Mat1f& depth_m,
                const cv::Mat1f& sigma_m) {
  depth_t message{};
  message.utime = to_utime(stamp);
  message.sequence = sequence;
  message.fx_px = camera.fx_px;
  message.fy_px = camera.fy_px;
  message.cx_px = camera.cx_px;
  message.cy_px = camera.cy_px;
  message.depth = quantise(depth_m, 1e-3);
  message.sigma = quantise(sigma_m, 1e-4);
  return message;
}

odometry_t to_wire(Time stamp, std::int64_t sequence, const SimulatedStep& step, const Pose& T_last_now,
                   double duration_s) {
  odometry_t message{};
  message.utime = to_utime(stamp);
  message.sequence = sequence;
  message.frame = "odom";
  message.child_frame = "body";
  set_pose(message, step.T_odom_body);
  if (duration_s > 0) {
    Eigen::Map<Eigen::Vector3d>(message.velocity_mps) = T_last_now.translation() / duration_s;
    Eigen::Map<Eigen::Vector3d>(message.angular_velocity_radps) = so3_log(T_last_now.linear()) / duration_s;
  }
  set_covariance(message.covariance, step.covariance);
  set_covariance(message.step_covariance, step.step_covariance);
  message.status = odometry_t::STATUS_OK;
  message.tracked = message.inliers = kPlausibleTracks;
  return message;
}

frame_alignment_t to_wire(Time stamp, const Pose& T_world_odom, double sigma_m, double sigma_rad) {
  frame_alignment_t message{};
  message.utime = to_utime(stamp);
  message.frame = "world";
  message.child_frame = "odom";
  set_pose(message, T_world_odom);
  Vector6d deviations;
  deviations << sigma_m, sigma_m, sigma_m, sigma_rad, sigma_rad, sigma_rad;
  set_covariance(message.covariance, deviations.cwiseAbs2().asDiagonal());
  message.views = 1;
  return message;
}

}  // namespace arpent::sim
