// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a live team leaves behind, made into the result that a team in lockstep gives (team_run.h): logs, the fused map,
// counters.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

#include "tools/mission/team_run.h"

namespace arpent::tools {

/// The raw log becomes mission.lcmlog beside it.
[[nodiscard]] MissionResult result_of_robot(const std::filesystem::path& raw_log, const MissionSpec& robot);

/// The same for the centre's: what it took and sent, as far as its bus tells.
[[nodiscard]] planning::CentreStatus status_of_centre(const std::filesystem::path& raw_log);

/// Of the fused map that the centre saved; the file is gone then. Empty if there is none.
[[nodiscard]] TriangleMesh take_mesh(const std::filesystem::path& map_file);

/// By channel as it is received, what all stations sent of it; `overhead` is the rest of what was on the air: headers,
/// seals, repairs, signs of life.
[[nodiscard]] std::map<std::string, std::int64_t> radio_bytes(const std::map<std::string, ProcessFigures>& processes,
                                                              std::int64_t on_air);

/// Says so if a simulator did not keep up with real time: then the robot was slower than its clock.
void warn_if_late(const TeamResult& result);

}  // namespace arpent::tools
