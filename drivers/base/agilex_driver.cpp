// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/agilex_driver.h"

#include <cmath>

#include "common/error.h"

namespace arpent::base {
namespace {

constexpr double kMetresPerCount = 1e-3;
/// What the fastest of these chassis can do; limits of the mission are the gate's.
constexpr double kChassisMaxMps = 3.0;
constexpr Duration kSilence{500000};

const char* describe(OdometerFault fault) {
  switch (fault) {
    case OdometerFault::kReset:
      return "was set to zero";
    case OdometerFault::kJump:
      return "jumped";
    case OdometerFault::kStuck:
      return "does not move although it is told to";
    case OdometerFault::kReversed:
      return "moves against its command";
    case OdometerFault::kNone:
      break;
  }
  return "";
}

}  // namespace

AgilexDriver::AgilexDriver(const AgilexParams& params, can::CanPort& port)
    : params_(params),
      port_(port),
      gate_(params.gate),
      left_(kMetresPerCount, kChassisMaxMps),
      right_(kMetresPerCount, kChassisMaxMps) {
  if (!(params.track_m > 0)) throw InputError("base: track_m must be > 0");
}

std::vector<std::string> AgilexDriver::step(Time now) {
  std::vector<std::string> faults;
  while (const auto received = port_.receive()) {
    const auto report = agilex::decode(received->frame);
    if (!report) {
      ++status_.bad_frames;
      continue;
    }
    std::visit([&](const auto& r) { take(r, now, faults); }, *report);
  }
  const bool heard = ever_heard_ && now - heard_at_ <= kSilence;
  if (status_.heard && !heard) faults.emplace_back("the chassis is silent");
  status_.heard = heard;
  commanded_ = gate_.output(now);
  // In standby the chassis ignores motion: ask for control whenever it is armed and nobody else has it.
  if (gate_.state() == GateState::kArmed && mode_ == agilex::Mode::kStandby) {
    send(agilex::encode_mode(agilex::Mode::kCan));
  }
  send(agilex::encode_motion(commanded_));
  return faults;
}

void AgilexDriver::take(const agilex::SystemState& state, Time now, std::vector<std::string>& faults) {
  heard_at_ = now;
  ever_heard_ = true;
  mode_ = state.mode;
  status_.battery_v = state.battery_v;
  const bool remote = state.mode == agilex::Mode::kRemote;
  if (remote && !status_.remote_control) faults.emplace_back("the remote control has the base");
  status_.remote_control = remote;
  const bool stopped = state.vehicle == agilex::VehicleState::kEmergencyStop;
  if (stopped && !status_.emergency_stop) faults.emplace_back("the emergency button of the chassis is pressed");
  // The button stops the stack too: what is released at the chassis is still latched here.
  if (stopped) gate_.stop();
  status_.emergency_stop = stopped;
}

void AgilexDriver::take(const agilex::MotionState& state, Time /*now*/, std::vector<std::string>& /*faults*/) {
  status_.twist = state.twist;
}

void AgilexDriver::take(const agilex::Odometry& odometry, Time now, std::vector<std::string>& faults) {
  const double turning = 0.5 * params_.track_m * commanded_.turn_rate_radps;
  const OdometerFault left = left_.update(odometry.left_mm, commanded_.speed_mps - turning, now);
  const OdometerFault right = right_.update(odometry.right_mm, commanded_.speed_mps + turning, now);
  const auto tell = [&](const char* side, OdometerFault fault, OdometerFault& known) {
    if (fault != known && fault != OdometerFault::kNone) {
      faults.push_back(std::string("the ") + side + " odometer " + describe(fault));
    }
    known = fault;
  };
  tell("left", left, left_fault_);
  tell("right", right, right_fault_);
  status_.stamp = now;
  status_.left_m = left_.way_m();
  status_.right_m = right_.way_m();
}

void AgilexDriver::send(const can::CanFrame& frame) {
  if (!port_.send(frame)) ++status_.refused_sends;
}

}  // namespace arpent::base
