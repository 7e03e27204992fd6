// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/system/team_trials.h"

#include <unistd.h>

#include "tools/mission/team_figures.h"

namespace arpent::bench {
namespace {

namespace fs = std::filesystem;

Trial run_one(const tools::MissionSpec& spec, const tools::MissionOptions& options) {
  const tools::MissionResult result = tools::run_mission(spec, options);
  const tools::MissionFigures figures = tools::measure(result);
  const tools::MissionSetting setting = tools::setting_of(spec, result);
  const auto evaluation = tools::evaluate_mission(setting, result, tools::legal_views(setting));
  return {result.done(),
          evaluation.reconstruction.coverage_percent,
          evaluation.reconstruction.errors.rmse_cm,
          figures.time_s,
          figures.path_m,
          0,
          result.collisions,
          0};
}

Trial run_many(const tools::MissionSpec& spec, const tools::MissionOptions& options) {
  const tools::TeamFigures figures = tools::measure(spec, tools::run_team(spec, options));
  return {figures.done,
          figures.evaluation.reconstruction.coverage_percent,
          figures.evaluation.reconstruction.errors.rmse_cm,
          figures.time_s,
          figures.path_m,
          figures.team_mb,
          figures.collisions,
          figures.encounters.overlaps};
}

}  // namespace

Trial run_trial(const TrialSpec& trial) {
  tools::MissionOverrides overrides;
  overrides.world = trial.world;
  overrides.seed = trial.seed;
  overrides.sensing = trial.sensing;
  overrides.robots = trial.robots;
  overrides.kill = trial.kill;
  overrides.settings = trial.settings;
  const fs::path file = fs::path(ARPENT_SOURCE_DIR "/config/missions") / (trial.mission + ".yaml");
  const tools::MissionSpec spec = tools::load_mission(file, overrides);
  tools::MissionOptions options;
  options.out = fs::temp_directory_path() / ("arpent_trial_" + std::to_string(getpid()));
  options.progress = false;
  const Trial result = trial.robots == 1 ? run_one(spec, options) : run_many(spec, options);
  fs::remove_all(options.out);
  return result;
}

double mean_of(const std::vector<Trial>& trials, double Trial::*member) {
  double sum = 0;
  for (const Trial& trial : trials) sum += trial.*member;
  return trials.empty() ? 0 : sum / static_cast<double>(trials.size());
}

void add_means(Report& report, const std::string& name, const std::vector<Trial>& trials) {
  int done = 0, collisions = 0, overlaps = 0;
  for (const Trial& trial : trials) {
    done += trial.done ? 1 : 0;
    collisions += trial.collisions;
    overlaps += trial.overlaps;
  }
  report.add(name + ".done_percent", 100.0 * done / static_cast<double>(trials.size()), "%", "bar 100");
  report.add(name + ".coverage_percent", mean_of(trials, &Trial::coverage_percent), "%");
  report.add(name + ".rmse_cm", mean_of(trials, &Trial::rmse_cm), "cm");
  report.add(name + ".time_s", mean_of(trials, &Trial::time_s), "s");
  report.add(name + ".path_m", mean_of(trials, &Trial::path_m), "m");
  report.add(name + ".team_mb", mean_of(trials, &Trial::team_mb), "MB");
  report.add(name + ".collisions", collisions, "1", "bar 0");
  report.add(name + ".overlaps", overlaps, "1", "bar 0");
}

}  // namespace arpent::bench
