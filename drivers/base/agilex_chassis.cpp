// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/agilex_chassis.h"

#include <cmath>

namespace arpent::base {
namespace {

constexpr Duration kCommandTimeout{500000};
constexpr double kUndervoltageFaultV = 22.0;
constexpr double kUndervoltageWarningV = 23.5;
/// Motion and odometry are reported every cycle, the system's state every fifth.
constexpr int kCyclesPerState = 5;

std::int32_t to_counter(double mm) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(std::floor(mm))));
}

}  // namespace

void AgilexChassis::take_remote_control(bool taken) {
  mode_ = taken ? agilex::Mode::kRemote : agilex::Mode::kStandby;
}

void AgilexChassis::restart() {
  mode_ = agilex::Mode::kStandby;
  command_ = wheels_ = {};
  left_mm_ = right_mm_ = 0;
  count_ = 0;
}

Twist2 AgilexChassis::twist() const {
  return {(1 - params_.slip) * wheels_.speed_mps, (1 - params_.slip) * wheels_.turn_rate_radps};
}

void AgilexChassis::read_commands(Time now) {
  while (const auto received = port_.receive()) {
    const auto mode = agilex::decode_mode(received->frame);
    if (mode && mode_ != agilex::Mode::kRemote) mode_ = *mode;
    const auto motion = agilex::decode_motion(received->frame);
    if (!motion || mode_ != agilex::Mode::kCan) continue;
    command_ = *motion;
    commanded_at_ = now;
  }
}

void AgilexChassis::step(Time now, double duration_s) {
  read_commands(now);
  const bool driven = mode_ == agilex::Mode::kCan && !button_ && now - commanded_at_ <= kCommandTimeout &&
                      params_.battery_v > kUndervoltageFaultV;
  const Twist2 wanted = driven ? command_ : Twist2{};
  const double keep = params_.lag_s > 0 ? std::exp(-duration_s / params_.lag_s) : 0.0;
  wheels_.speed_mps = wanted.speed_mps + keep * (wheels_.speed_mps - wanted.speed_mps);
  wheels_.turn_rate_radps = wanted.turn_rate_radps + keep * (wheels_.turn_rate_radps - wanted.turn_rate_radps);
  const double turning = 0.5 * params_.track_m * wheels_.turn_rate_radps;
  left_mm_ += 1e3 * (wheels_.speed_mps - turning) * duration_s;
  right_mm_ += 1e3 * (wheels_.speed_mps + turning) * duration_s;
  report();
}

void AgilexChassis::report() {
  // Reports that the bus refuses are lost, as from the real one.
  (void)port_.send(agilex::encode(agilex::MotionState{wheels_}));
  (void)port_.send(agilex::encode(agilex::Odometry{to_counter(left_mm_), to_counter(right_mm_)}));
  if (cycle_++ % kCyclesPerState != 0) return;
  agilex::SystemState state;
  state.vehicle = button_ ? agilex::VehicleState::kEmergencyStop : agilex::VehicleState::kNormal;
  state.mode = mode_;
  state.battery_v = params_.battery_v;
  state.undervoltage_fault = params_.battery_v <= kUndervoltageFaultV;
  state.undervoltage_warning = params_.battery_v <= kUndervoltageWarningV;
  state.count = count_++;
  (void)port_.send(agilex::encode(state));
}

}  // namespace arpent::base
