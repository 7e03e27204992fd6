// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/base_driver.h"

#include "common/config/config.h"

namespace arpent::base {
namespace {

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

void tell(const char* side, OdometerFault fault, OdometerFault& known, std::vector<std::string>& faults) {
  if (fault != known && fault != OdometerFault::kNone) {
    faults.push_back(std::string("the ") + side + " odometer " + describe(fault));
  }
  known = fault;
}

}  // namespace

BaseDriver::BaseDriver(const DriverParams& params, double unit_m, double max_speed_mps)
    : gate_(params.gate),
      geometry_(params.geometry),
      dry_run_(params.dry_run),
      left_(unit_m * params.geometry.left_scale, max_speed_mps),
      right_(unit_m * params.geometry.right_scale, max_speed_mps) {
  config::check(params.geometry, "base");
  config::check(params.gate.limits, "base");
}

void BaseDriver::stop() {
  gate_.stop();
  status_.commanded = {};
  send_motion({});
}

void BaseDriver::expire(Time now) {
  gate_.watch(now);
  if (status_.commanded == Twist2{} || gate_.output(now) != Twist2{}) return;
  status_.commanded = {};
  send_motion({});
}

void BaseDriver::take_odometers(std::int32_t left, std::int32_t right, Time stamp, std::vector<std::string>& faults) {
  const double turning = 0.5 * geometry_.track_m * status_.commanded.turn_rate_radps;
  const double told = status_.commanded.speed_mps;
  tell("left", left_.update(left, told - turning, stamp), left_fault_, faults);
  tell("right", right_.update(right, told + turning, stamp), right_fault_, faults);
  status_.stamp = stamp;
  status_.left_m = left_.way_m();
  status_.right_m = right_.way_m();
}

void BaseDriver::take_sign_of_life(Time now) {
  heard_at_ = now;
  ever_heard_ = true;
}

void BaseDriver::lose_port() {
  if (gate_.state() == GateState::kArmed) gate_.stop();
}

void BaseDriver::judge_silence(Time now, std::vector<std::string>& faults) {
  const bool heard = ever_heard_ && now - heard_at_ <= kSilence;
  if (status_.heard && !heard) {
    faults.emplace_back("the base is silent");
    gate_.disarm();
  }
  status_.heard = heard;
}

}  // namespace arpent::base
