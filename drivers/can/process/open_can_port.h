// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The one place where a CAN port is chosen: from a text in a robot file or a flag.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "drivers/can/can_port.h"

namespace arpent::can {

/// `spec`: a network interface ("can0"), "socket:PATH" (a hub that the mock owns), "candump:FILE" (replay) or "bus"
/// (channel CAN). `place`: the name of this end, e.g. "driver". `heard_ids`: standard identifiers that it needs,
/// for the kernel's filter; empty: all. A port that is not there yet is opened later, by
/// itself; its state says so meanwhile. Throws InputError for a spec that cannot mean anything. Bus and clock must
/// outlive the port.
[[nodiscard]] std::unique_ptr<CanPort> open_can_port(const std::string& spec, const std::string& place, Bus& bus,
                                                     Clock& clock, const std::vector<std::uint32_t>& heard_ids = {});

}  // namespace arpent::can
