// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a team's mission was worth, in figures, and its report.
#pragma once

#include <optional>

#include "tools/mission/evaluate.h"
#include "tools/mission/team_run.h"

namespace arpent::tools {

struct TeamFigures {
  bool done = false;   ///< every robot that lived to the end is done
  double time_s = 0;   ///< from the start to the end of the last robot
  double path_m = 0;   ///< of all
  double team_mb = 0;  ///< on the air
  int collisions = 0;  ///< with the world or each other
  TeamEncounters encounters;
  std::vector<MissionFigures> robots;  ///< beside TeamResult::names
  double realtime_factor = 0;
  MissionSetting setting;
  MissionEvaluation evaluation;  ///< of the fused map
};

[[nodiscard]] TeamFigures measure(const MissionSpec& spec, const TeamResult& result);
void print(const TeamFigures& figures);
/// Rows NAME.done, .coverage_percent, .time_s, .team_mb, .overlaps and so on.
[[nodiscard]] nlohmann::json to_rows(const MissionSpec& spec, const TeamResult& result, const TeamFigures& figures);

/// report.html, mesh.ply and mission.json in `folder`; R1/truth.tum, R1/estimate.tum and so on.
void write_team_report(const std::filesystem::path& folder, const MissionSpec& spec, const TeamResult& result,
                       const TeamFigures& figures);

}  // namespace arpent::tools
