// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The live half of run.h: separate processes, in real time.
#pragma once

#include "tools/mission/run.h"

namespace arpent::tools {

[[nodiscard]] MissionResult run_live_mission(const MissionSpec& spec, const MissionOptions& options);

/// CONFIG events at the head of a mission's log.
void write_configs(LogWriter& log, Time time, const MissionSpec& spec);

/// True once Ctrl-C or SIGTERM has come; the first call listens for them.
[[nodiscard]] bool interrupted();

}  // namespace arpent::tools
