// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/evaluate.h"

#include <algorithm>
#include <fstream>

#include "common/error.h"

namespace arpent::tools {
namespace {

/// The first robot of a team: its log says what place it was.
const char* const kFirstRobot = "R1";

void append(nlohmann::json& rows, const std::string& name, double value, const char* unit) {
  rows.push_back({{"name", name}, {"value", value}, {"unit", unit}});
}

bool is_of_team(const std::filesystem::path& folder) {
  return !std::filesystem::exists(folder / "mission.lcmlog") && std::filesystem::exists(folder / kFirstRobot);
}

/// The fused map is judged anew; what was counted while the team drove is as its own file has it.
nlohmann::json evaluate_team_folder(const std::filesystem::path& folder, const std::filesystem::path& world) {
  MissionFolder mission = read_mission_folder(folder / kFirstRobot, world);
  mission.result.mesh = read_ply(folder / "mesh.ply");
  std::ifstream in(folder / "mission.json");
  const auto written = nlohmann::json::parse(in, nullptr, false);
  if (!written.is_array() || written.empty()) throw InputError((folder / "mission.json").string() + ": has no figures");
  const std::string first = written.front().value("name", "");
  const std::string name = first.substr(0, first.rfind('.'));
  nlohmann::json rows = nlohmann::json::array();
  append_figures(rows, name, evaluate_mission(mission.setting, mission.result, legal_views(mission.setting)));
  const std::size_t judged = rows.size();
  for (const auto& row : written) {
    const bool anew = std::any_of(rows.begin(), rows.begin() + static_cast<std::ptrdiff_t>(judged),
                                  [&](const auto& r) { return r["name"] == row.value("name", ""); });
    if (!anew) rows.push_back(row);
  }
  return rows;
}

}  // namespace

MissionEvaluation evaluate_mission(const MissionSetting& setting, const MissionResult& result,
                                   const evaluation::LegalViews& views) {
  MissionEvaluation evaluation;
  evaluation.truth = evaluation::find_true_surface(setting.world, views);
  evaluation.reconstruction = evaluation::evaluate_reconstruction(evaluation.truth, result.mesh, setting.voxel_m());
  return evaluation;
}

void append_figures(nlohmann::json& rows, const std::string& name, const MissionEvaluation& evaluation) {
  const evaluation::Reconstruction& r = evaluation.reconstruction;
  append(rows, name + ".coverage_percent", r.coverage_percent, "%");
  append(rows, name + ".rmse_cm", r.errors.rmse_cm, "cm");
  append(rows, name + ".mean_cm", r.errors.mean_cm, "cm");
  append(rows, name + ".std_cm", r.errors.std_cm, "cm");
  append(rows, name + ".beyond_percent", r.beyond_percent, "%");
  append(rows, name + ".visible_percent", evaluation.truth.visible_percent(), "%");
  append(rows, name + ".e_max_cm", 100 * r.e_max_m, "cm");
}

nlohmann::json evaluate_folder(const std::filesystem::path& folder, const std::filesystem::path& world) {
  if (is_of_team(folder)) return evaluate_team_folder(folder, world);
  const MissionFolder mission = read_mission_folder(folder, world);
  const std::string& name = mission.setting.name;
  const MissionEvaluation evaluation = evaluate_mission(mission.setting, mission.result, legal_views(mission.setting));
  const MissionFigures figures = measure(mission.result);
  nlohmann::json rows = nlohmann::json::array();
  append_figures(rows, name, evaluation);
  append(rows, name + ".done", mission.result.done() ? 1 : 0, "1");
  append(rows, name + ".time_s", figures.time_s, "s");
  append(rows, name + ".path_m", figures.path_m, "m");
  append(rows, name + ".duty_cycle_percent", figures.duty_cycle_percent, "%");
  append(rows, name + ".ate_m", figures.ate_m, "m");
  if (mission.collisions) append(rows, name + ".collisions", *mission.collisions, "1");
  if (mission.realtime_factor) append(rows, name + ".realtime_factor", *mission.realtime_factor, "1");
  return rows;
}

}  // namespace arpent::tools
