// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/agilex_chassis.h"

namespace arpent::base {
namespace {

constexpr Duration kCommandTimeout{500000};
constexpr Duration kReportPeriod{20000};
constexpr double kUndervoltageFaultV = 22.0;
constexpr double kUndervoltageWarningV = 23.5;
/// Motion and odometry are reported every cycle, the system's state every fifth.
constexpr int kCyclesPerState = 5;

}  // namespace

AgilexChassis::AgilexChassis(const ChassisParams& params, can::CanPort& port)
    : port_(port), motors_(params.motors), battery_v_(params.battery_v) {}

void AgilexChassis::take_remote_control(bool taken, const Twist2& sticks) {
  mode_ = taken ? agilex::Mode::kRemote : agilex::Mode::kStandby;
  sticks_ = sticks;
}

void AgilexChassis::restart() {
  mode_ = agilex::Mode::kStandby;
  command_ = {};
  motors_.restart();
  count_ = 0;
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

Twist2 AgilexChassis::wanted(Time now) const {
  if (button_ || battery_v_ <= kUndervoltageFaultV) return {};
  if (mode_ == agilex::Mode::kRemote) return sticks_;
  return mode_ == agilex::Mode::kCan && now - commanded_at_ <= kCommandTimeout ? command_ : Twist2{};
}

void AgilexChassis::step(Time now, double duration_s) {
  read_commands(now);
  motors_.step(wanted(now), duration_s);
  if (now < report_due_) return;
  report_due_ = (now - report_due_ < kReportPeriod ? report_due_ : now) + kReportPeriod;
  report();
}

void AgilexChassis::report() {
  // Reports that the bus refuses are lost, as from the real one.
  (void)port_.send(agilex::encode(agilex::MotionState{motors_.wheel_twist()}));
  (void)port_.send(agilex::encode(agilex::Odometry{motors_.count(Side::kLeft), motors_.count(Side::kRight)}));
  if (cycle_++ % kCyclesPerState == 0) {
    agilex::SystemState state;
    state.vehicle = button_ ? agilex::VehicleState::kEmergencyStop : agilex::VehicleState::kNormal;
    state.mode = mode_;
    state.battery_v = battery_v_;
    state.undervoltage_fault = battery_v_ <= kUndervoltageFaultV;
    state.undervoltage_warning = battery_v_ <= kUndervoltageWarningV;
    state.count = count_++;
    (void)port_.send(agilex::encode(state));
  }
  port_.flush();
}

}  // namespace arpent::base
