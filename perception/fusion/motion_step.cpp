// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/motion_step.h"

#include <cmath>

namespace arpent::fusion {
namespace {

// Where speed or turn rate are only held: how wrong they are, and for how long in the same way.
constexpr double kHeldSigmaMps = 0.5;
constexpr double kHeldSigmaRadps = 0.5;
constexpr double kHeldCorrelationS = 0.3;
/// The scales of wheels change with load and ground.
constexpr double kDistanceScaleWalk = 0.001;
constexpr double kTurnScaleWalk = 0.005;
/// A turn on the spot by a radian changes the slope under the robot like this way does.
constexpr double kWayPerTurnM = 0.3;

double squared(double x) {
  return x * x;
}

/// One quantity of the arc: its value, its variance, and how it depends on one of the estimated parameters.
struct Quantity {
  double value = 0;
  double variance = 0;
  int parameter = -1;
  double derivative = 0;
};

Quantity make_turn(const Interval& interval, const Estimated& e, bool use_wheels, const FusionParams& p) {
  const double dt = interval.duration_s;
  if (interval.gyro_rad) {
    return {*interval.gyro_rad - e.gyro_bias_radps * dt, squared(p.gyro.noise_radps_per_sqrt_hz) * dt, kGyroBias, -dt};
  }
  if (use_wheels) {
    const double raw = interval.wheels->turn_rad;
    const double turn = (1 + e.turn_scale) * raw;
    return {turn,
            squared(p.wheels.noise_rad_per_sqrt_m) * std::abs(interval.wheels->distance_m) +
                squared(p.wheels.noise_rad_per_sqrt_rad) * std::abs(turn),
            kTurnScale, raw};
  }
  return {e.held.turn_rate_radps * dt, squared(kHeldSigmaRadps) * kHeldCorrelationS * dt};
}

Quantity make_distance(const Interval& interval, const Estimated& e, bool use_wheels, double turn_rad,
                       const FusionParams& p) {
  if (use_wheels) {
    const double raw = interval.wheels->distance_m;
    return {(1 + e.distance_scale) * raw,
            squared(p.wheels.noise_m_per_sqrt_m) * std::abs(raw) +
                squared(p.wheels.noise_m_per_sqrt_rad) * std::abs(turn_rad),
            kDistanceScale, raw};
  }
  return {e.held.speed_mps * interval.duration_s, squared(kHeldSigmaMps) * kHeldCorrelationS * interval.duration_s};
}

}  // namespace

MotionStep make_motion_step(const Interval& interval, const Estimated& estimated, bool use_wheels,
                            const FusionParams& params) {
  const Quantity turn = make_turn(interval, estimated, use_wheels, params);
  const Quantity distance = make_distance(interval, estimated, use_wheels, turn.value, params);
  const double c = std::cos(0.5 * turn.value), s = std::sin(0.5 * turn.value);
  MotionStep step;
  step.T_before_after.linear() = Eigen::AngleAxisd(turn.value, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  step.T_before_after.translation() = distance.value * Eigen::Vector3d(c, s, 0);
  step.twist = {distance.value / interval.duration_s, turn.value / interval.duration_s};

  // Derivatives of the arc in the axes of its end.
  Vector6d J_distance = Vector6d::Zero(), J_turn = Vector6d::Zero();
  J_distance.head<2>() << c, -s;
  J_turn.head<2>() << 0.5 * distance.value * s, 0.5 * distance.value * c;
  J_turn(5) = 1;
  step.F.topLeftCorner<6, 6>() = adjoint(step.T_before_after.inverse());
  if (turn.parameter >= 0) step.F.col(turn.parameter).head<6>() += turn.derivative * J_turn;
  if (distance.parameter >= 0) step.F.col(distance.parameter).head<6>() += distance.derivative * J_distance;

  step.Q.topLeftCorner<6, 6>() =
      distance.variance * J_distance * J_distance.transpose() + turn.variance * J_turn * J_turn.transpose();
  step.Q(1, 1) += use_wheels ? squared(params.wheels.sideways_noise_m_per_sqrt_m) * std::abs(distance.value) +
                                   squared(params.wheels.noise_m_per_sqrt_rad) * std::abs(turn.value)
                             : 0.1 * distance.variance;
  step.Q(kGyroBias, kGyroBias) = squared(params.gyro.bias_walk_radps_per_sqrt_s) * interval.duration_s;
  step.Q(kDistanceScale, kDistanceScale) = squared(kDistanceScaleWalk) * std::abs(distance.value);
  step.Q(kTurnScale, kTurnScale) = squared(kTurnScaleWalk) * std::abs(turn.value);

  // Roll, pitch and height as Ornstein-Uhlenbeck processes over the way.
  const double way_m = std::abs(distance.value) + kWayPerTurnM * std::abs(turn.value);
  step.ground_keep = std::exp(-way_m / params.ground.reach_m);
  step.F.middleRows<3>(2) *= step.ground_keep;
  const double fresh = 1 - squared(step.ground_keep);
  step.Q(2, 2) += fresh * squared(params.ground.sigma_m);
  step.Q(3, 3) += fresh * squared(params.ground.sigma_rad);
  step.Q(4, 4) += fresh * squared(params.ground.sigma_rad);
  return step;
}

MotionStep standing_step(const Interval& interval, const FusionParams& params) {
  MotionStep step;
  step.Q(kGyroBias, kGyroBias) = squared(params.gyro.bias_walk_radps_per_sqrt_s) * interval.duration_s;
  return step;
}

Pose revert_to_ground(const Pose& T_frame_body, double keep) {
  if (keep == 1) return T_frame_body;
  const double yaw_rad = std::atan2(T_frame_body.linear()(1, 0), T_frame_body.linear()(0, 0));
  const Eigen::Matrix3d R_yaw = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Vector3d tilt_rad = so3_log(R_yaw.transpose() * T_frame_body.linear());
  Pose T = T_frame_body;
  T.translation().z() *= keep;
  T.linear() = R_yaw * so3_exp({keep * tilt_rad.x(), keep * tilt_rad.y(), tilt_rad.z()});
  return T;
}

void apply(const MotionStep& step, MotionCovariance& covariance) {
  covariance = (step.F * covariance * step.F.transpose() + step.Q).eval();
}

void apply(const MotionStep& step, StateCovariance& P) {
  P.topLeftCorner<kClone, kClone>() = (step.F * P.topLeftCorner<kClone, kClone>() * step.F.transpose() + step.Q).eval();
  P.topRightCorner<kClone, 6>() = (step.F * P.topRightCorner<kClone, 6>()).eval();
  P.bottomLeftCorner<6, kClone>() = P.topRightCorner<kClone, 6>().transpose();
}

}  // namespace arpent::fusion
