// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/motion_filter.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "perception/fusion/motion_step.h"

namespace arpent::fusion {
namespace {

/// Beyond this many deviations (3 degrees of freedom) a step does not belong to a robot on the ground.
constexpr double kOffGroundSquared = 36;
/// Chi squared with 6 degrees of freedom, 99.9 %: gate of tags and alignments.
constexpr double kWorldGate = 22.5;
constexpr double kStandingRadps = 0.03;
/// Odometry that moves while the base stands is refused beyond this many gates; below, it has no weight anyway.
constexpr double kStandingGate = 1.5;
/// What a few milliseconds between the clocks of gyro, wheels and camera make when a turn begins.
constexpr double kTurnMarginRad = 0.003;
constexpr double kJumpMarginM = 0.03;
constexpr double kJumpMarginRad = 0.02;
constexpr double kLeapSigmaM = 0.5;
constexpr double kLeapSigmaRad = 0.5;
/// What wheels that slip may be wrong by, as a speed.
constexpr double kSlipSigmaMps = 0.5;
constexpr double kSlipSigmaRadps = 1.0;

template <int kRows>
using Jacobian = Eigen::Matrix<double, kRows, kStates>;

/// The Kalman update in Joseph's form; `r` = measurement - prediction.
template <int kRows>
void update(FilterState& state, const Jacobian<kRows>& H, const Eigen::Matrix<double, kRows, 1>& r,
            const Eigen::Matrix<double, kRows, kRows>& R) {
  const Eigen::Matrix<double, kRows, kRows> S = H * state.P * H.transpose() + R;
  const Eigen::Matrix<double, kStates, kRows> K = S.llt().solve(H * state.P).transpose();
  const Eigen::Matrix<double, kStates, 1> dx = K * r;
  const StateCovariance A = StateCovariance::Identity() - K * H;
  state.P = (A * state.P * A.transpose() + K * R * K.transpose()).eval();
  state.P = (0.5 * (state.P + state.P.transpose())).eval();
  state.T_frame_body = retract(state.T_frame_body, dx.segment<6>(kPose));
  state.gyro_bias_radps += dx(kGyroBias);
  state.distance_scale += dx(kDistanceScale);
  state.turn_scale += dx(kTurnScale);
  if (state.clone) state.clone->T_frame_body = retract(state.clone->T_frame_body, dx.segment<6>(kClone));
}

double sigma_of(double variance) {
  return std::sqrt(std::max(variance, 0.0));
}

/// Squared distance of `r` in deviations of `S`.
double distance_squared(const Vector6d& r, const Matrix6d& S) {
  return r.dot(S.llt().solve(r));
}

void add_to_pose(FilterState& state, const Vector6d& sigma) {
  state.P.diagonal().segment<6>(kPose) += sigma.cwiseAbs2();
}

/// Moves pose and clone into another frame, uncertain by `covariance` in the axes of the old one.
void change_frame(FilterState& state, const Pose& T_new_old, const Matrix6d& covariance) {
  Eigen::Matrix<double, kStates, 6> J = Eigen::Matrix<double, kStates, 6>::Zero();
  J.block<6, 6>(kPose, 0) = adjoint(state.T_frame_body.inverse());
  state.T_frame_body = T_new_old * state.T_frame_body;
  if (state.clone) {
    J.block<6, 6>(kClone, 0) = adjoint(state.clone->T_frame_body.inverse());
    state.clone->T_frame_body = T_new_old * state.clone->T_frame_body;
  }
  state.P += J * covariance * J.transpose();
}

/// How far odometry is from what wheels and gyro predict, in deviations of both.
struct Disagreement {
  double turn_sigmas = 0;
  double way_sigmas = 0;
};

Disagreement compare(const Drift& predicted, const Pose& T_then_now, const Matrix6d& R) {
  const Vector6d error = local(predicted.T_then_now, T_then_now);
  const Matrix6d S = predicted.covariance.topLeftCorner<6, 6>() + R;
  const Eigen::Vector2d way = error.head<2>();
  return {std::abs(error(5)) / sigma_of(S(5, 5) + std::pow(kTurnMarginRad, 2)),
          std::sqrt(way.dot(S.topLeftCorner<2, 2>().llt().solve(way)))};
}

/// Puts the body elsewhere, and the clone along with it.
void set_anew(FilterState& state, const Pose& T_world_body, const Matrix6d& covariance) {
  for (const int block : {static_cast<int>(kPose), static_cast<int>(kClone)}) {
    state.P.middleRows<6>(block).setZero();
    state.P.middleCols<6>(block).setZero();
  }
  Eigen::Matrix<double, kStates, 6> J = Eigen::Matrix<double, kStates, 6>::Zero();
  J.block<6, 6>(kPose, 0).setIdentity();
  if (state.clone) {
    const Pose T_body_clone = state.T_frame_body.inverse() * state.clone->T_frame_body;
    J.block<6, 6>(kClone, 0) = adjoint(T_body_clone.inverse());
    state.clone->T_frame_body = T_world_body * T_body_clone;
  }
  state.T_frame_body = T_world_body;
  state.P += J * covariance * J.transpose();
}

/// The drift since some moment, from that moment on: only the parameters are uncertain.
Drift begin_drift(const FilterState& state) {
  Drift drift;
  constexpr int kParameters = kClone - kGyroBias;
  drift.covariance.bottomRightCorner<kParameters, kParameters>() =
      state.P.block<kParameters, kParameters>(kGyroBias, kGyroBias);
  return drift;
}

}  // namespace

FilterState MotionFilter::initial(Time stamp) const {
  FilterState state;
  state.stamp = stamp;
  state.P(kGyroBias, kGyroBias) = std::pow(params_.gyro.bias_sigma_radps, 2);
  state.P(kDistanceScale, kDistanceScale) = std::pow(params_.wheels.distance_scale_sigma, 2);
  state.P(kTurnScale, kTurnScale) = std::pow(params_.wheels.turn_scale_sigma, 2);
  return state;
}

bool MotionFilter::stands(const FilterState& state, const Interval& interval) const {
  if (!interval.wheels || !interval.wheels->still) return false;
  if (!interval.gyro_rad) return true;
  const double rate_radps = *interval.gyro_rad / interval.duration_s - state.gyro_bias_radps;
  const double variance =
      state.P(kGyroBias, kGyroBias) + std::pow(params_.gyro.noise_radps_per_sqrt_hz, 2) / interval.duration_s;
  return std::abs(rate_radps) < std::max(kStandingRadps, 4 * sigma_of(variance));
}

/// A gyro that stands shows its bias.
void MotionFilter::learn_bias(FilterState& state, const Interval& interval) const {
  Jacobian<1> H = Jacobian<1>::Zero();
  H(kGyroBias) = 1;
  const double rate_radps = *interval.gyro_rad / interval.duration_s;
  const double variance = std::pow(params_.gyro.noise_radps_per_sqrt_hz, 2) / interval.duration_s;
  update<1>(state, H, Eigen::Matrix<double, 1, 1>(rate_radps - state.gyro_bias_radps),
            Eigen::Matrix<double, 1, 1>(variance));
}

void MotionFilter::predict(FilterState& state, const Interval& interval) const {
  if (!(interval.duration_s > 0)) return;
  const Estimated estimated{state.gyro_bias_radps, state.distance_scale, state.turn_scale, state.odometry_twist};
  const bool still = stands(state, interval);
  const bool use_wheels = interval.wheels && !state.slipping;
  const MotionStep step =
      still ? standing_step(interval, params_) : make_motion_step(interval, estimated, use_wheels, params_);
  state.T_frame_body = revert_to_ground(state.T_frame_body * step.T_before_after, step.ground_keep);
  apply(step, state.P);
  state.since_odometry.T_then_now = state.since_odometry.T_then_now * step.T_before_after;
  apply(step, state.since_odometry.covariance);
  const MotionStep of_wheels =
      still || use_wheels ? step : make_motion_step(interval, estimated, interval.wheels.has_value(), params_);
  state.since_clone.T_then_now = state.since_clone.T_then_now * of_wheels.T_before_after;
  apply(of_wheels, state.since_clone.covariance);
  state.wheels_since_clone &= interval.wheels.has_value();
  state.gyro_since_clone &= interval.gyro_rad.has_value();
  state.still_since_clone &= still;
  state.twist = step.twist;
  if (still && interval.gyro_rad) learn_bias(state, interval);
}

void MotionFilter::start(FilterState& state, const OdometryReading& reading) const {
  state.T_frame_body = reading.T_odom_body;
  state.P.topRows<6>().setZero();
  state.P.leftCols<6>().setZero();
  state.P.topLeftCorner<6, 6>() = reading.covariance;
  state.since_odometry = begin_drift(state);
  state.started = true;
  state.odometry_stamp = reading.stamp;
}

void MotionFilter::set_clone(FilterState& state, const OdometryReading& reading) const {
  state.clone = {reading.stamp, reading.sequence, state.T_frame_body, reading.T_odom_body};
  state.P.block<6, kStates>(kClone, 0) = state.P.block<6, kStates>(kPose, 0).eval();
  state.P.block<kStates, 6>(0, kClone) = state.P.block<kStates, 6>(0, kPose).eval();
  state.since_clone = begin_drift(state);
  state.wheels_since_clone = state.gyro_since_clone = state.still_since_clone = true;
}

/// Why the step since the clone cannot be the robot's, empty if it can. `motion`: that step.
std::string MotionFilter::find_jump(const FilterState& state, const OdometryReading& reading,
                                    const Vector6d& motion) const {
  const OdometryTrust& trust = params_.odometry;
  const double step_s = to_seconds(reading.stamp - state.clone->stamp);
  const double since_used_s = to_seconds(reading.stamp - *state.odometry_stamp);
  const Vector6d sigma = reading.step_covariance.diagonal().cwiseSqrt();
  const double margin_m = kJumpMarginM + 3 * sigma.head<3>().norm();
  const double margin_rad = kJumpMarginRad + 3 * sigma.tail<3>().norm();
  const double speed_change = trust.max_acceleration_mps2 * since_used_s;
  const double turn_change = trust.max_turn_acceleration_radps2 * since_used_s;
  const double change_m = std::abs(motion(0) - state.odometry_twist.speed_mps * step_s);
  const double change_rad = std::abs(motion(5) - state.odometry_twist.turn_rate_radps * step_s);
  if (motion.head<3>().norm() > trust.max_speed_mps * step_s + margin_m ||
      change_m > speed_change * step_s + margin_m) {
    return "visual odometry jumped";
  }
  if (motion.tail<3>().norm() > trust.max_turn_rate_radps * step_s + margin_rad ||
      change_rad > turn_change * step_s + margin_rad) {
    return "visual odometry jumped in rotation";
  }
  return "";
}

void MotionFilter::use_motion(FilterState& state, const OdometryReading& reading) const {
  const FilterState::Clone& clone = *state.clone;
  const Pose T_clone_now = clone.T_odom_body.inverse() * reading.T_odom_body;
  const Vector6d motion = local(Pose::Identity(), T_clone_now);
  // Pairs between that never came may have added error of their own.
  const double pairs = static_cast<double>(std::max<std::int64_t>(reading.sequence - clone.sequence, 1));
  const Matrix6d R = pairs * reading.step_covariance;
  state.odometry_fault = find_jump(state, reading, motion);
  if (!state.odometry_fault.empty()) return;

  const Disagreement wheels = compare(state.since_clone, T_clone_now, R);
  const double gate = params_.odometry.gate_sigmas;
  if (state.still_since_clone && std::max(wheels.turn_sigmas, wheels.way_sigmas) > kStandingGate * gate) {
    state.odometry_fault = "visual odometry moves while the base stands";
    return;
  }
  if (state.gyro_since_clone && wheels.turn_sigmas > gate) {
    state.odometry_fault = "visual odometry turns otherwise than the gyro";
    return;
  }

  Jacobian<6> H = Jacobian<6>::Zero();
  const Pose T_clone_predicted = clone.T_frame_body.inverse() * state.T_frame_body;
  H.block<6, 6>(0, kPose).setIdentity();
  H.block<6, 6>(0, kClone) = -adjoint(T_clone_predicted.inverse());
  const Vector6d r = local(T_clone_predicted, T_clone_now);
  const Eigen::Vector3d off_ground = r.segment<3>(2);
  const Matrix6d S = H * state.P * H.transpose() + R;
  if (off_ground.dot(S.block<3, 3>(2, 2).llt().solve(off_ground)) > kOffGroundSquared) {
    state.odometry_fault = "visual odometry leaves the ground";
    return;
  }
  const bool slips =
      state.wheels_since_clone && !state.still_since_clone && std::max(wheels.turn_sigmas, wheels.way_sigmas) > gate;
  const double step_s = to_seconds(reading.stamp - clone.stamp);
  if (slips) {
    Vector6d sigma = Vector6d::Zero();
    sigma.head<2>().setConstant(kSlipSigmaMps * step_s);
    if (!state.gyro_since_clone) sigma(5) = kSlipSigmaRadps * step_s;
    add_to_pose(state, sigma);
    state.slips += state.slipping ? 0 : 1;
  }
  state.slipping = slips;
  update<6>(state, H, r, R);
  state.odometry_stamp = reading.stamp;
  state.odometry_twist = {motion(0) / step_s, motion(5) / step_s};
  state.since_odometry = begin_drift(state);
}

void MotionFilter::correct(FilterState& state, const OdometryReading& reading) const {
  // A first pair, or the first after a loss, says where motion counts from, and measures none.
  const bool measures_motion = reading.step_covariance.diagonal().minCoeff() > 0;
  if (!reading.usable) {
    state.odometry_fault = reading.reason.empty() ? "visual odometry lost" : "visual odometry: " + reading.reason;
  } else if (!state.started) {
    start(state, reading);
    state.odometry_fault.clear();
  } else if (state.clone && measures_motion && reading.stamp > state.clone->stamp) {
    use_motion(state, reading);
    state.refused_odometry += state.odometry_fault.empty() ? 0 : 1;
  } else {
    state.odometry_fault = "visual odometry starts anew";
  }
  if (state.started && (reading.usable || reading.anchored)) set_clone(state, reading);
}

void MotionFilter::correct(FilterState& state, const AlignmentReading& reading) const {
  if (!state.started) {
    ++state.refused_alignments;
    return;
  }
  const Pose T_frame_odom =
      state.clone ? state.clone->T_frame_body * state.clone->T_odom_body.inverse() : Pose::Identity();
  if (state.frame == Frame::kOdom) {
    const Pose T_odom_frame = T_frame_odom.inverse();
    const Matrix6d Ad = adjoint(T_odom_frame.inverse());
    change_frame(state, reading.T_world_odom * T_odom_frame, Ad * reading.covariance * Ad.transpose());
    state.frame = Frame::kWorld;
    state.T_world_last_tag = state.T_frame_body;
    return;
  }
  const Pose T_odom_body = T_frame_odom.inverse() * state.T_frame_body;
  const Pose T_world_body = reading.T_world_odom * T_odom_body;
  const Matrix6d Ad = adjoint(T_odom_body.inverse());
  const Matrix6d R = Ad * reading.covariance * Ad.transpose();
  const Vector6d r = local(state.T_frame_body, T_world_body);
  Jacobian<6> H = Jacobian<6>::Zero();
  H.block<6, 6>(0, kPose).setIdentity();
  const Matrix6d floor = (Vector6d() << Eigen::Vector3d::Constant(std::pow(params_.tags.floor_m, 2)),
                          Eigen::Vector3d::Constant(std::pow(params_.tags.floor_rad, 2)))
                             .finished()
                             .asDiagonal();
  if (distance_squared(r, state.P.block<6, 6>(kPose, kPose) + R + floor) < kWorldGate) {
    state.T_world_odom_suspect.reset();
    // Tags bring the same information view by view.
    if (!params_.tags.used) update<6>(state, H, r, R + floor);
    return;
  }
  ++state.refused_alignments;
  const bool confirmed =
      state.T_world_odom_suspect &&
      distance_squared(local(*state.T_world_odom_suspect * T_odom_body, T_world_body), 2 * (R + floor)) < kWorldGate;
  state.T_world_odom_suspect = reading.T_world_odom;
  if (!confirmed) return;
  set_anew(state, T_world_body, R + floor);
  state.T_world_odom_suspect.reset();
}

void MotionFilter::correct(FilterState& state, const WorldReading& tag) const {
  if (state.frame != Frame::kWorld || !params_.tags.used) return;
  if (state.T_world_last_tag) {
    // A second look from the same place repeats the first one's error and says nothing new.
    const Vector6d moved = local(*state.T_world_last_tag, state.T_frame_body);
    if (moved.head<3>().norm() < params_.tags.spacing_m && moved.tail<3>().norm() < params_.tags.spacing_rad) return;
  }
  Matrix6d R = tag.covariance;
  R.diagonal().head<3>().array() += std::pow(params_.tags.floor_m, 2);
  R.diagonal().tail<3>().array() += std::pow(params_.tags.floor_rad, 2);
  const Vector6d r = local(state.T_frame_body, tag.T_world_body);
  if (distance_squared(r, state.P.block<6, 6>(kPose, kPose) + R) > kWorldGate) {
    ++state.refused_tags;
    return;
  }
  Jacobian<6> H = Jacobian<6>::Zero();
  H.block<6, 6>(0, kPose).setIdentity();
  update<6>(state, H, r, R);
  state.T_world_last_tag = state.T_frame_body;
  ++state.used_tags;
}

void MotionFilter::leap(FilterState& state, Time to) const {
  Vector6d sigma = Vector6d::Zero();
  sigma.head<2>().setConstant(kLeapSigmaM);
  sigma(5) = kLeapSigmaRad;
  add_to_pose(state, sigma);
  state.since_odometry.covariance.diagonal().head<6>() += sigma.cwiseAbs2();
  state.clone.reset();
  state.P.bottomRows<6>().setZero();
  state.P.rightCols<6>().setZero();
  state.odometry_fault = "the time of the messages leapt";
  state.twist = {};
  state.odometry_twist = {};
  state.odometry_stamp = to;
  state.stamp = to;
}

}  // namespace arpent::fusion
