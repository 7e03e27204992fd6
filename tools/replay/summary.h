// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a replay gave, in figures, on the terminal and as a report page.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/evaluation/trajectory.h"
#include "tools/replay/replay.h"
#include "tools/report/html.h"

namespace arpent::tools {

struct Summary {
  std::vector<report::Figure> figures;
  std::vector<std::string> warnings;
  std::optional<evaluation::TrajectoryErrors> errors;  ///< if the truth is known
  std::optional<ReplayDifference> difference;          ///< live against lockstep
  std::optional<double> reprojection_bad2_percent;     ///< disparity rendered from the map against trusted disparity
};

/// `live` may be nullptr.
[[nodiscard]] Summary summarise(const ReplayInput& input, const ReplayResult& result, const ReplayResult* live);
void print(const Summary& summary);
/// report.html, mesh.ply and trajectory.tum in `folder`. Throws InputError.
void write_replay_report(const std::filesystem::path& folder, const ReplayInput& input, const ReplayResult& result,
                         const Summary& summary);

/// Share [%] of trusted disparities, in pairs that the map was not made from, that differ from the disparity rendered
/// from the mesh by more than 2 px (or where the mesh has nothing). nullopt if there is nothing to compare.
[[nodiscard]] std::optional<double> measure_reprojection(const ReplayInput& input, const ReplayResult& result);

}  // namespace arpent::tools
