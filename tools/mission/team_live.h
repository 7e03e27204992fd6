// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The live half of team_run.h: each robot's processes on a bus of its own and the centre's on another, each bus in a
// network namespace of its own, and between them real team_link_processes over a radio that loses and delays frames
// (common/net/tap_hub.h). Only the simulators meet elsewhere: they tell each other where the robots truly are
// (sim/process/truth_socket.h).
#pragma once

#include "tools/mission/team_run.h"

namespace arpent::tools {

/// Throws InputError where network namespaces are refused, a process ends for good, or the links do not find each
/// other.
[[nodiscard]] TeamResult run_live_team(const MissionSpec& spec, const MissionOptions& options);

}  // namespace arpent::tools
