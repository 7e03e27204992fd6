// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The part of a mission's report that judges what was reconstructed: pictures of the mesh, of its errors and of what is
// missing; coverage and incomplete surface over time; a film of the growing map; where the time went.
#pragma once

#include "tools/mission/evaluate.h"
#include "tools/report/html.h"
#include "tools/report/mesh_view.h"

namespace arpent::tools {

/// Reads the mission's log once more; seconds.
void add_reconstruction(report::Page& page, const MissionSetting& setting, const MissionResult& result,
                        const MissionEvaluation& evaluation);

/// Three pictures from above: the mesh with the ways driven, its signed errors, the true surface found and missed.
void add_pictures(report::Page& page, const MissionSetting& setting, const TriangleMesh& mesh,
                  const std::vector<report::ViewPath>& ways, const MissionEvaluation& evaluation);

/// The world's obstacles from above, for plots with equal axes.
[[nodiscard]] std::vector<report::Curve> outline(const sim::World& world);

/// Where the time of a mission went [s], from its first command to its last.
struct TimeBudget {
  double driving_s = 0;   ///< |v| >= 0.2 m/s
  double turning_s = 0;   ///< slower, |w| >= 0.5 rad/s
  double creeping_s = 0;  ///< slower than either, but moving
  double standing_s = 0;
};
[[nodiscard]] TimeBudget time_budget(const std::vector<StampedTwist>& commands);

/// The report of a folder, from nothing but the folder, in `out`/report.html.
void write_reconstruction_report(const std::filesystem::path& folder, const std::filesystem::path& world,
                                 const std::filesystem::path& out);

/// Coverage [%] and incomplete surface over time [s] and driven way [m], as CSV.
void write_growth(const std::filesystem::path& folder, const std::filesystem::path& world,
                  const std::filesystem::path& csv);

}  // namespace arpent::tools
