// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/system/mission_trials.h"

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "tools/certificate/check.h"
#include "tools/mission/evaluate.h"
#include "tools/mission/figures.h"

namespace arpent::bench {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kJobs = 2;

/// Runs one mission in `folder`, and leaves its figures there.
void run_trial(const Trial& trial, const fs::path& folder) {
  cv::setNumThreads(1);
  const tools::MissionSpec spec = tools::load_mission(trial.mission, trial.overrides);
  tools::MissionOptions options;
  options.out = folder;
  options.threads = 1;
  options.progress = false;
  const tools::MissionResult result = tools::run_mission(spec, options);
  tools::write_mission_report(folder, spec, result, tools::measure(result));
  json figures = json::object();
  for (const json& row : tools::evaluate_folder(folder, {})) {
    const auto name = row.at("name").get<std::string>();
    figures[name.substr(name.find('.') + 1)] = row.at("value");
  }
  const tools::CertificateCheck check = tools::check_folder(folder, {});
  figures["certificate.valid_percent"] = check.valid_percent();
  figures["certificate.true_percent"] = check.true_percent();
  figures["unfinished"] = check.unfinished + (result.done() ? 0 : 1);
  std::ofstream(folder / "figures.json") << figures;
}

TrialFigures read_figures(const fs::path& folder) {
  std::ifstream in(folder / "figures.json");
  return in ? json::parse(in).get<TrialFigures>() : TrialFigures{};
}

double sum(const std::vector<double>& values) {
  double total = 0;
  for (const double value : values) total += value;
  return total;
}

bool is_count(const std::string& name) {
  return name == "collisions" || name == "unfinished" || name == "done";
}

}  // namespace

std::vector<TrialFigures> run_trials(const std::vector<Trial>& trials) {
  const fs::path scratch = fs::temp_directory_path() / fmt::format("arpent_missions_{}", getpid());
  std::size_t running = 0;
  for (std::size_t i = 0; i < trials.size(); ++i) {
    if (running == kJobs && wait(nullptr) > 0) --running;
    std::fflush(nullptr);
    if (fork() == 0) {
      try {
        run_trial(trials[i], scratch / std::to_string(i));
      } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", trials[i].mission.c_str(), error.what());
      }
      _exit(0);
    }
    ++running;
  }
  while (wait(nullptr) > 0) {
  }
  std::vector<TrialFigures> figures;
  for (std::size_t i = 0; i < trials.size(); ++i) figures.push_back(read_figures(scratch / std::to_string(i)));
  fs::remove_all(scratch);
  return figures;
}

void add_mission_rows(Report& report, const std::string& bench, const std::vector<TrialFigures>& trials,
                      const std::vector<MissionColumn>& columns) {
  report.add(bench + ".runs", static_cast<double>(trials.size()), "1");
  for (const MissionColumn& column : columns) {
    std::vector<double> values;
    for (const TrialFigures& figures : trials) {
      if (const auto found = figures.find(column.name); found != figures.end()) values.push_back(found->second);
    }
    // A mission that did not even run has no figures: it shows as missing runs, not as a better mean.
    if (values.size() != trials.size()) {
      report.add(bench + "." + column.name, std::nan(""), column.unit, "some missions failed to run");
      continue;
    }
    const auto n = static_cast<double>(values.size());
    const double mean = sum(values) / n;
    const bool counted = is_count(column.name);
    report.add(bench + "." + column.name, counted ? sum(values) : mean, column.unit, column.bar);
    if (counted || values.size() < 2) continue;
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean);
    report.add(bench + "." + column.name + "_std", std::sqrt(squares / (n - 1)), column.unit);
  }
}

void measure_mission(Report& report, const std::string& bench, const std::string& mission_file, int seeds,
                     const std::map<std::string, std::string>& bars) {
  std::vector<Trial> trials(static_cast<std::size_t>(seeds));
  for (int i = 0; i < seeds; ++i) {
    trials[static_cast<std::size_t>(i)].mission = mission_file;
    trials[static_cast<std::size_t>(i)].overrides.seed = i + 1;
  }
  std::vector<MissionColumn> columns{{"coverage_percent", "%", ""},
                                     {"rmse_cm", "cm", ""},
                                     {"time_s", "s", ""},
                                     {"path_m", "m", ""},
                                     {"duty_cycle_percent", "%", ""},
                                     {"ate_m", "m", ""},
                                     {"collisions", "1", "bar 0"},
                                     {"realtime_factor", "1", ""},
                                     {"done", "1", ""},
                                     {"certificate.valid_percent", "%", ""},
                                     {"unfinished", "1", ""}};
  for (MissionColumn& column : columns) {
    if (const auto bar = bars.find(column.name); bar != bars.end()) column.bar = bar->second;
  }
  add_mission_rows(report, bench, run_trials(trials), columns);
}

}  // namespace arpent::bench
