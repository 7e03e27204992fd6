// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Runs a team, in lockstep or live (team_live.h): each robot's processes on its own bus, a centre on another, a radio
// between them, all robots in one world. Each bus has its own log (R1/mission.lcmlog, centre/mission.lcmlog).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "planning/team/centre.h"
#include "tools/mission/encounters.h"
#include "tools/mission/run.h"

namespace arpent::tools {

struct TeamResult {
  std::vector<std::string> names;
  std::vector<MissionResult> robots;  ///< beside names; without meshes
  std::vector<std::string> died;
  TriangleMesh mesh;  ///< of the fused map
  planning::CentreStatus centre;
  std::map<std::string, std::int64_t> radio_bytes;  ///< on the air, by channel
  TeamEncounters encounters;
  std::map<std::string, ProcessFigures> processes;  ///< by bus and name
  double cpu_s = 0;
  double wall_s = 0;
  std::string log_fault;  ///< why one of the logs is not complete
};

/// Throws InputError for a team that cannot be: of another kind than explore, more robots than starts.
[[nodiscard]] TeamResult run_team(const MissionSpec& spec, const MissionOptions& options);

}  // namespace arpent::tools
