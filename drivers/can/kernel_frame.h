// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Frames as Linux writes them (struct can_frame), on CAN sockets and on the local hub's; and what its error frames say
// about the port's state (linux/can/error.h).
#pragma once

#include <linux/can.h>

#include <optional>

#include "drivers/can/can_port.h"

namespace arpent::can {

[[nodiscard]] can_frame to_kernel(const CanFrame& frame);
/// nullopt for remote and error frames and for impossible sizes.
[[nodiscard]] std::optional<CanFrame> from_kernel(const can_frame& frame);

[[nodiscard]] inline bool is_error_frame(const can_frame& frame) {
  return (frame.can_id & CAN_ERR_FLAG) != 0;
}
/// The error frame with which a controller enters a state up to kBusOff; kActive is "restarted".
[[nodiscard]] can_frame make_error_frame(PortState state);

/// Takes an error frame: the new state (unchanged if it says nothing of it), restarts and errors counted.
[[nodiscard]] PortState take_error_frame(const can_frame& frame, PortState before, PortCounters& counters);

}  // namespace arpent::can
