// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_port.h"

namespace arpent::can {

const char* describe(PortState state) {
  switch (state) {
    case PortState::kActive:
      return "working";
    case PortState::kPassive:
      return "error-passive: many errors on the bus";
    case PortState::kBusOff:
      return "bus-off: the controller takes no part until it is restarted (ip link set … type can restart-ms 100)";
    case PortState::kGone:
      return "not there";
  }
  return "";
}

}  // namespace arpent::can
