// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/team_figures.h"

#include <algorithm>
#include <cstdio>

namespace arpent::tools {
namespace {

/// The evaluation looks at one mesh and one start.
MissionResult as_of_one(const TeamResult& team) {
  MissionResult one;
  one.mesh = team.mesh;
  one.truth = team.robots.front().truth;
  return one;
}

bool lived(const TeamResult& team, std::size_t robot) {
  return std::find(team.died.begin(), team.died.end(), team.names[robot]) == team.died.end();
}

}  // namespace

TeamFigures measure(const MissionSpec& spec, const TeamResult& result) {
  TeamFigures figures;
  figures.encounters = result.encounters;
  figures.done = result.died.size() < result.names.size();
  for (std::size_t i = 0; i < result.robots.size(); ++i) {
    figures.robots.push_back(measure(result.robots[i]));
    const MissionFigures& robot = figures.robots.back();
    figures.path_m += robot.path_m;
    figures.collisions += result.robots[i].collisions;
    if (!lived(result, i)) continue;
    figures.done = figures.done && result.robots[i].done();
    figures.time_s = std::max(figures.time_s, robot.time_s);
  }
  for (const auto& [channel, bytes] : result.radio_bytes) figures.team_mb += 1e-6 * static_cast<double>(bytes);
  if (result.cpu_s > 0) figures.realtime_factor = figures.time_s / result.cpu_s;
  const MissionResult one = as_of_one(result);
  figures.setting = setting_of(spec, one);
  figures.evaluation = evaluate_mission(figures.setting, one, legal_views(figures.setting));
  return figures;
}

void print(const TeamFigures& f) {
  const evaluation::Reconstruction& r = f.evaluation.reconstruction;
  std::printf("mission          %s\n", f.done ? "done" : "not done");
  std::printf("coverage, RMSE   %.1f %%, %.2f cm\n", r.coverage_percent, r.errors.rmse_cm);
  std::printf("time, way        %.1f s, %.1f m\n", f.time_s, f.path_m);
  for (std::size_t i = 0; i < f.robots.size(); ++i) {
    const MissionFigures& robot = f.robots[i];
    std::printf("  R%zu             %.1f s, %.1f m, duty cycle %.0f %%, pose error %.3f m, collisions %d\n", i + 1,
                robot.time_s, robot.path_m, robot.duty_cycle_percent, robot.ate_m, robot.collisions);
  }
  std::printf("radio            %.2f MB\n", f.team_mb);
  std::printf("collisions       %d, overlaps %d, least gap %.2f m\n", f.collisions, f.encounters.overlaps,
              f.encounters.least_gap_m);
  std::printf("speed            %.2f x real time on one core\n", f.realtime_factor);
}

nlohmann::json to_rows(const MissionSpec& spec, const TeamResult& result, const TeamFigures& f) {
  nlohmann::json rows = nlohmann::json::array();
  const auto add = [&](const std::string& name, double value, const char* unit) {
    rows.push_back({{"name", spec.name + "." + name}, {"value", value}, {"unit", unit}});
  };
  add("done", f.done ? 1 : 0, "1");
  add("robots", static_cast<double>(result.names.size()), "1");
  add("time_s", f.time_s, "s");
  add("path_m", f.path_m, "m");
  for (std::size_t i = 0; i < f.robots.size(); ++i) {
    add("path_" + result.names[i] + "_m", f.robots[i].path_m, "m");
    add("ate_" + result.names[i] + "_m", f.robots[i].ate_m, "m");
  }
  add("team_mb", f.team_mb, "MB");
  for (const auto& [channel, bytes] : result.radio_bytes) {
    add("team_mb_" + channel, 1e-6 * static_cast<double>(bytes), "MB");
  }
  add("collisions", f.collisions, "1");
  add("overlaps", f.encounters.overlaps, "1");
  add("least_gap_m", f.encounters.least_gap_m, "m");
  add("realtime_factor", f.realtime_factor, "1");
  append_figures(rows, spec.name, f.evaluation);
  return rows;
}

}  // namespace arpent::tools
