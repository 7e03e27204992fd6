// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/agilex_driver.h"

namespace arpent::base {
namespace {

constexpr double kMetresPerCount = 1e-3;
/// What the fastest of these chassis can do; limits of the mission are the gate's.
constexpr double kChassisMaxMps = 3.0;
/// A flood of frames does not keep a cycle from its command; a full bus carries 100 frames in 20 ms.
constexpr int kMostFrames = 1000;

}  // namespace

AgilexDriver::AgilexDriver(const DriverParams& params, can::CanPort& port)
    : BaseDriver(params, kMetresPerCount, kChassisMaxMps), port_(port) {}

std::vector<std::string> AgilexDriver::step(Time now) {
  Faults faults;
  for (int i = 0; i < kMostFrames; ++i) {
    const auto received = port_.receive();
    if (!received) break;
    const auto report = agilex::decode(received->frame);
    if (report) {
      std::visit([&](const auto& r) { take(r, received->stamp, faults); }, *report);
    } else if (agilex::is_report(received->frame)) {
      ++status_.bad_frames;
    }
  }
  watch_port(faults);
  judge_silence(now, faults);
  status_.commanded = gate_.output(now);
  // In standby the chassis ignores motion: ask for control whenever it is armed and nobody else has it.
  if (gate_.state() == GateState::kArmed && last_ && last_->mode == agilex::Mode::kStandby) {
    send(agilex::encode_mode(agilex::Mode::kCan));
  }
  send_motion(status_.commanded);
  return faults;
}

void AgilexDriver::send_motion(const Twist2& twist) {
  send(agilex::encode_motion(twist));
  port_.flush();
}

void AgilexDriver::watch_port(Faults& faults) {
  const can::PortState state = port_.state();
  if (state != port_state_) {
    const std::string why = port_.fault();
    faults.push_back(std::string("the CAN port is ") + can::describe(state) + (why.empty() ? "" : ": " + why));
  }
  if (state != port_state_ && state > can::PortState::kPassive) lose_port();
  port_state_ = state;
  const std::int64_t restarts = port_.counters().restarts;
  if (restarts != restarts_) {
    faults.emplace_back("the CAN port was restarted");
    lose_port();
  }
  restarts_ = restarts;
}

void AgilexDriver::take(const agilex::SystemState& state, Time stamp, Faults& faults) {
  // A count that stands still comes from something that repeats itself, not from a chassis that is alive.
  if (!last_ || last_->count != state.count) take_sign_of_life(stamp);
  status_.battery_v = state.battery_v;
  const bool stopped = state.vehicle == agilex::VehicleState::kEmergencyStop;
  const bool remote = state.mode == agilex::Mode::kRemote;
  const auto tell = [&](bool is, bool was, const char* what) {
    if (is && !was) faults.emplace_back(what);
  };
  tell(remote, status_.remote_control, "the remote control has the base");
  tell(stopped, status_.emergency_button, "the emergency button of the chassis is pressed");
  tell(state.undervoltage_fault, last_ && last_->undervoltage_fault, "the battery is empty: the chassis stands");
  tell(state.vehicle == agilex::VehicleState::kException, last_ && last_->vehicle == agilex::VehicleState::kException,
       "the chassis reports an exception");
  // Who takes the base by hand gives back one that stands.
  if (remote && !status_.remote_control) gate_.disarm();
  // The button stops the stack too: what is released at the chassis is still latched here.
  if (stopped) gate_.stop();
  status_.remote_control = remote;
  status_.emergency_button = stopped;
  last_ = state;
}

void AgilexDriver::take(const agilex::MotionState& state, Time /*stamp*/, Faults& /*faults*/) {
  status_.twist = state.twist;
}

void AgilexDriver::take(const agilex::Odometry& odometry, Time stamp, Faults& faults) {
  take_odometers(odometry.left_mm, odometry.right_mm, stamp, faults);
}

void AgilexDriver::send(const can::CanFrame& frame) {
  if (!dry_run_ && !port_.send(frame)) ++status_.refused_sends;
}

}  // namespace arpent::base
