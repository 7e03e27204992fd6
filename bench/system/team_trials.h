// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Whole missions of teams (and of one robot, to compare) for the benchmarks: run, evaluate, forget.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/harness.h"
#include "tools/mission/mission_file.h"

namespace arpent::bench {

struct TrialSpec {
  std::string mission;               ///< of config/missions, without .yaml
  std::filesystem::path world = {};  ///< instead of the mission's; empty: the mission's
  int robots = 2;
  int seed = 1;
  std::string sensing = "images";
  std::string kill = {};
  std::vector<std::string> settings = {};
};

struct Trial {
  bool done = false;
  double coverage_percent = 0, rmse_cm = 0, time_s = 0, path_m = 0, team_mb = 0;
  int collisions = 0, overlaps = 0;
};

[[nodiscard]] Trial run_trial(const TrialSpec& spec);

/// The means of several trials as rows NAME.done_percent, .coverage_percent, .rmse_cm, .time_s, .path_m, .team_mb, and
/// the sums .collisions, .overlaps.
void add_means(Report& report, const std::string& name, const std::vector<Trial>& trials);

/// Mean of a member over trials.
[[nodiscard]] double mean_of(const std::vector<Trial>& trials, double Trial::*member);

}  // namespace arpent::bench
