// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wheel_motors.h"

#include <algorithm>
#include <cmath>

#include "common/config/config.h"

namespace arpent::base {
namespace {

double encoder_gain(EncoderFault fault) {
  switch (fault) {
    case EncoderFault::kStuck:
      return 0;
    case EncoderFault::kReversed:
      return -1;
    case EncoderFault::kDoubled:
      return 2;
    case EncoderFault::kNone:
      break;
  }
  return 1;
}

}  // namespace

WheelMotors::WheelMotors(const MotorParams& params) : params_(params) {
  config::check(params, "motors");
}

void WheelMotors::step(double left_wanted_mps, double right_wanted_mps, double duration_s) {
  const double follow = params_.lag_s > 0 ? 1 - std::exp(-duration_s / params_.lag_s) : 1.0;
  const double most = params_.max_acceleration_mps2 * duration_s;
  const std::array scales{params_.geometry.left_scale, params_.geometry.right_scale};
  const std::array wanted{left_wanted_mps, right_wanted_mps};
  for (std::size_t i = 0; i < 2; ++i) {
    // An obstacle takes the wheels' speed at once: its stiffness is beyond the motors'.
    const double target = blocked_ ? params_.blocked_share * wanted[i] : wanted[i];
    const double change = std::clamp(follow * (target - speeds_mps_[i]), -most, most);
    speeds_mps_[i] = blocked_ ? target : speeds_mps_[i] + change;
    counts_[i] += encoder_gain(faults_[i]) * speeds_mps_[i] * duration_s / scales[i] * params_.counts_per_m;
  }
}

void WheelMotors::step(const Twist2& wanted, double duration_s) {
  const double turning = 0.5 * params_.geometry.track_m * wanted.turn_rate_radps;
  step(wanted.speed_mps - turning, wanted.speed_mps + turning, duration_s);
}

Twist2 WheelMotors::twist(double left_mps, double right_mps) const {
  return {0.5 * (left_mps + right_mps), (right_mps - left_mps) / params_.geometry.track_m};
}

Twist2 WheelMotors::ground_twist() const {
  return twist((1 - params_.left_slip) * speeds_mps_[0], (1 - params_.right_slip) * speeds_mps_[1]);
}

Twist2 WheelMotors::wheel_twist() const {
  return twist(encoder_gain(faults_[0]) * speeds_mps_[0], encoder_gain(faults_[1]) * speeds_mps_[1]);
}

std::int32_t WheelMotors::count(Side side) const {
  return static_cast<std::int32_t>(
      static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(counts_[index(side)]))));
}

void WheelMotors::set_slip(double left, double right) {
  params_.left_slip = left;
  params_.right_slip = right;
}

void WheelMotors::restart() {
  speeds_mps_ = {};
  counts_ = {};
}

}  // namespace arpent::base
