// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of the base: wheel_command_t, wheel_state_t, base_request_t.
#pragma once

#include <arpent/base_request_t.hpp>
#include <arpent/wheel_command_t.hpp>
#include <arpent/wheel_state_t.hpp>
#include <cstdint>
#include <string>

#include "common/result.h"
#include "common/time.h"
#include "drivers/base/base_driver.h"

namespace arpent::base {

/// What the base shall do, from the pose of `stamp`.
struct WheelCommand {
  Time stamp;
  Twist2 twist;
};
[[nodiscard]] wheel_command_t to_wire(const WheelCommand& command);
/// Checks finiteness; limits are the gate's.
[[nodiscard]] Result<WheelCommand> from_wire(const wheel_command_t& message);

/// The base as others hear of it.
struct WheelState {
  std::int64_t sequence = 0;
  BaseStatus status;
  GateState gate = GateState::kDisarmed;
  std::string fault;
};
[[nodiscard]] wheel_state_t to_wire(const WheelState& state);
/// Checks finiteness, flags and the gate's range.
[[nodiscard]] Result<WheelState> from_wire(const wheel_state_t& message);

enum class Action : std::int8_t { kArm = 1, kDisarm = 2, kRelease = 3 };
struct BaseRequest {
  Time stamp;
  Action action = Action::kDisarm;
  std::string source;
};
[[nodiscard]] base_request_t to_wire(const BaseRequest& request);
[[nodiscard]] Result<BaseRequest> from_wire(const base_request_t& message);

}  // namespace arpent::base
