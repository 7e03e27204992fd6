// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/robot/sim_odometry.h"

#include <cmath>

namespace arpent::sim {
namespace {

/// Deviation of what a standing camera measures, and of height, roll and pitch.
constexpr double kFloorM = 2e-4;
constexpr double kFloorRad = 1e-4;

}  // namespace

SimOdometry::SimOdometry(const OdometryNoise& noise, std::uint64_t seed) : noise_(noise), random_(seed) {
  scale_ = 1 + noise_.scale * std::normal_distribution<double>()(random_);
}

SimulatedStep SimOdometry::move_to(const Pose2& pose) {
  if (!started_) {
    started_ = true;
    last_ = pose;
    return estimate_;
  }
  const Pose T_step = last_.to_pose().inverse() * pose.to_pose();
  const double way_m = T_step.translation().norm();
  const double turn_rad = std::abs(wrap_angle(pose.yaw_rad - last_.yaw_rad));
  last_ = pose;
  const double sigma_m = std::hypot(kFloorM, noise_.translation_m_per_sqrt_m * std::sqrt(way_m));
  const double sigma_rad = std::hypot(kFloorRad, std::hypot(noise_.rotation_rad_per_sqrt_rad * std::sqrt(turn_rad),
                                                            noise_.rotation_rad_per_sqrt_m * std::sqrt(way_m)));
  std::normal_distribution<double> normal;
  Vector6d error = Vector6d::Zero();
  error(0) = sigma_m * normal(random_);
  error(1) = sigma_m * normal(random_);
  error(5) = sigma_rad * normal(random_);
  Pose T_measured = T_step;
  T_measured.translation() *= scale_;
  estimate_.T_odom_body = retract(estimate_.T_odom_body * T_measured, error);
  const double scaled_m = std::hypot(sigma_m, noise_.scale * way_m);
  Vector6d variances;
  variances << scaled_m * scaled_m, scaled_m * scaled_m, kFloorM * kFloorM, kFloorRad * kFloorRad,
      kFloorRad * kFloorRad, sigma_rad * sigma_rad;
  estimate_.step_covariance = variances.asDiagonal();
  // The heading's error turns the way into an error across it; the rest adds up.
  const double heading_variance = estimate_.covariance(5, 5);
  estimate_.covariance += estimate_.step_covariance;
  estimate_.covariance(1, 1) += heading_variance * way_m * way_m;
  return estimate_;
}

}  // namespace arpent::sim
