// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/process/open_can_port.h"

#include "common/error.h"
#include "drivers/can/process/bus_port.h"

namespace arpent::can {

std::unique_ptr<CanPort> open_can_port(const std::string& spec, const std::string& place, Bus& bus, Clock& clock) {
  if (spec == "bus") return std::make_unique<BusPort>(place, bus, clock);
  throw InputError("CAN port '" + spec + "': must be an interface (can0), socket:PATH, candump:FILE or bus");
}

}  // namespace arpent::can
