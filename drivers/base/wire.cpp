// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wire.h"

#include <cmath>

namespace arpent::base {
namespace {

static_assert(static_cast<std::int8_t>(GateState::kDisarmed) == wheel_state_t::GATE_DISARMED);
static_assert(static_cast<std::int8_t>(GateState::kArmed) == wheel_state_t::GATE_ARMED);
static_assert(static_cast<std::int8_t>(GateState::kStopped) == wheel_state_t::GATE_STOPPED);
static_assert(static_cast<std::int8_t>(Action::kArm) == base_request_t::ACTION_ARM);
static_assert(static_cast<std::int8_t>(Action::kDisarm) == base_request_t::ACTION_DISARM);
static_assert(static_cast<std::int8_t>(Action::kRelease) == base_request_t::ACTION_RELEASE);

bool is_flag(std::int8_t value) {
  return value == 0 || value == 1;
}

}  // namespace

wheel_command_t to_wire(const WheelCommand& command) {
  wheel_command_t message{};
  message.utime = to_utime(command.stamp);
  message.speed_mps = command.twist.speed_mps;
  message.turn_rate_radps = command.twist.turn_rate_radps;
  return message;
}

Result<WheelCommand> from_wire(const wheel_command_t& message) {
  const WheelCommand command{from_utime(message.utime), {message.speed_mps, message.turn_rate_radps}};
  if (!command.twist.finite()) return Fault{"the command is not finite"};
  return command;
}

wheel_state_t to_wire(const WheelState& state) {
  wheel_state_t message{};
  message.utime = to_utime(state.status.stamp);
  message.sequence = state.sequence;
  message.left_m = state.status.left_m;
  message.right_m = state.status.right_m;
  message.speed_mps = state.status.twist.speed_mps;
  message.turn_rate_radps = state.status.twist.turn_rate_radps;
  message.commanded_speed_mps = state.status.commanded.speed_mps;
  message.commanded_turn_rate_radps = state.status.commanded.turn_rate_radps;
  message.battery_v = state.status.battery_v;
  message.gate = static_cast<std::int8_t>(state.gate);
  message.heard = state.status.heard ? 1 : 0;
  message.remote_control = state.status.remote_control ? 1 : 0;
  message.emergency_button = state.status.emergency_button ? 1 : 0;
  message.fault = state.fault;
  return message;
}

Result<WheelState> from_wire(const wheel_state_t& message) {
  WheelState state;
  state.sequence = message.sequence;
  state.fault = message.fault;
  BaseStatus& status = state.status;
  status.stamp = from_utime(message.utime);
  status.left_m = message.left_m;
  status.right_m = message.right_m;
  status.twist = {message.speed_mps, message.turn_rate_radps};
  status.commanded = {message.commanded_speed_mps, message.commanded_turn_rate_radps};
  status.battery_v = message.battery_v;
  if (!std::isfinite(status.left_m) || !std::isfinite(status.right_m) || !std::isfinite(status.battery_v) ||
      !status.twist.finite() || !status.commanded.finite()) {
    return Fault{"a value is not finite"};
  }
  if (!is_flag(message.heard) || !is_flag(message.remote_control) || !is_flag(message.emergency_button)) {
    return Fault{"a flag is neither 0 nor 1"};
  }
  if (message.gate < wheel_state_t::GATE_DISARMED || message.gate > wheel_state_t::GATE_STOPPED) {
    return Fault{"the gate's state is unknown"};
  }
  status.heard = message.heard != 0;
  status.remote_control = message.remote_control != 0;
  status.emergency_button = message.emergency_button != 0;
  state.gate = static_cast<GateState>(message.gate);
  return state;
}

base_request_t to_wire(const BaseRequest& request) {
  base_request_t message{};
  message.utime = to_utime(request.stamp);
  message.action = static_cast<std::int8_t>(request.action);
  message.source = request.source;
  return message;
}

Result<BaseRequest> from_wire(const base_request_t& message) {
  if (message.action < base_request_t::ACTION_ARM || message.action > base_request_t::ACTION_RELEASE) {
    return Fault{"the action is unknown"};
  }
  return BaseRequest{from_utime(message.utime), static_cast<Action>(message.action), message.source};
}

}  // namespace arpent::base
