// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What missions in lockstep have in common, of one robot (run.h) and of a team (team_run.h).
#pragma once

#include <chrono>

#include "tools/mission/run.h"

namespace arpent::tools {

/// Any time will do; a date makes logs readable. The same for every run, so that logs can be compared.
inline constexpr Time kStart{std::chrono::seconds(1767225600)};  // 2026-01-01
inline constexpr Duration kStartAfter = std::chrono::milliseconds(500);
inline constexpr Duration kStep = std::chrono::milliseconds(200);
/// After the end the base has still to come to rest.
inline constexpr Duration kRunOut = std::chrono::seconds(1);

/// The robot's processes that neither map nor plan, in their order.
SimProcess& add_robot(LockstepStack& stack, const MissionSpec& robot, const std::string& prefix = "");

}  // namespace arpent::tools
