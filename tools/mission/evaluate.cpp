// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/evaluate.h"

namespace arpent::tools {
namespace {

void append(nlohmann::json& rows, const std::string& name, double value, const char* unit) {
  rows.push_back({{"name", name}, {"value", value}, {"unit", unit}});
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
