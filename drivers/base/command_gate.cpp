// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/command_gate.h"

#include <cmath>

namespace arpent::base {
namespace {

constexpr double kRounding = 1e-6;

bool is_zero(const Twist2& t) {
  return t.speed_mps == 0 && t.turn_rate_radps == 0;
}

}  // namespace

void CommandGate::watch(Time now) {
  if (slept(now)) {
    awake_since_ = now;
    accepted_.reset();
  }
  watched_ = now;
}

std::optional<std::string> CommandGate::offer(const Twist2& command, Time received) {
  if (!command.finite()) return "the command is not finite";
  heard_ = command;
  heard_at_ = received;
  const bool just_awake = awake_since_ && received - *awake_since_ <= params_.command_lifetime;
  if (just_awake || slept(received)) return "the driver has slept: the command may have waited for any time";
  if (state_ == GateState::kStopped) return "the emergency stop is latched";
  if (state_ == GateState::kDisarmed) return "the base is not armed";
  if (std::abs(command.speed_mps) > params_.limits.max_speed_mps + kRounding ||
      std::abs(command.turn_rate_radps) > params_.limits.max_turn_rate_radps + kRounding) {
    return "the command is beyond the limits";
  }
  seen_zero_ = seen_zero_ || is_zero(command);
  if (!seen_zero_) return "commands were flowing before the base was armed: send zero first";
  accepted_ = command;
  received_ = received;
  return std::nullopt;
}

Twist2 CommandGate::output(Time now) const {
  return state_ == GateState::kArmed && accepted_ && fresh(now) ? *accepted_ : Twist2{};
}

std::optional<std::string> CommandGate::arm() {
  if (state_ == GateState::kStopped) return "the emergency stop is latched: release it first";
  if (state_ == GateState::kArmed) return std::nullopt;
  state_ = GateState::kArmed;
  accepted_.reset();
  // Silence counts as zero; a stream that already flows does not.
  seen_zero_ = !heard_ || is_zero(*heard_);
  return std::nullopt;
}

void CommandGate::disarm() {
  if (state_ == GateState::kArmed) state_ = GateState::kDisarmed;
  accepted_.reset();
}

std::optional<std::string> CommandGate::release(Time now) {
  if (state_ != GateState::kStopped) return std::nullopt;
  const bool flowing = heard_ && !is_zero(*heard_) && now - heard_at_ <= params_.command_lifetime;
  if (flowing) return "commands other than zero are still coming in";
  state_ = GateState::kDisarmed;
  accepted_.reset();
  return std::nullopt;
}

}  // namespace arpent::base
