// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The figures of a reconstruction mission as rows of name, value, unit: those of the drive (figures.h) and those of the
// mesh against the true surface (tools/evaluation/reconstruction.h).
#pragma once

#include <nlohmann/json.hpp>

#include "tools/mission/folder.h"

namespace arpent::tools {

struct MissionEvaluation {
  evaluation::TrueSurface truth;
  evaluation::Reconstruction reconstruction;
};
/// The mesh of `result` against the setting's world.
[[nodiscard]] MissionEvaluation evaluate_mission(const MissionSetting& setting, const MissionResult& result,
                                                 const evaluation::LegalViews& views);

/// Appends rows NAME.coverage_percent, .rmse_cm, .mean_cm, .std_cm, .beyond_percent, .visible_percent, .e_max_cm.
void append_figures(nlohmann::json& rows, const std::string& name, const MissionEvaluation& evaluation);

/// Of a team's folder the fused map, judged anew, and what its own file counted. Otherwise
/// all figures of a mission's folder, recomputed: those, and done, time_s, path_m, duty_cycle_percent, ate_m,
/// collisions, realtime_factor (the last two as the mission's own file has them, if at all).
[[nodiscard]] nlohmann::json evaluate_folder(const std::filesystem::path& folder, const std::filesystem::path& world);

}  // namespace arpent::tools
