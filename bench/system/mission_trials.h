// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Missions for benchmarks: each run in a process of its own, two at a time, and what it was worth in figures.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "bench/harness.h"
#include "tools/mission/mission_file.h"

namespace arpent::bench {

struct Trial {
  std::filesystem::path mission;
  tools::MissionOverrides overrides;
};

/// Figures of `./arpent evaluate mission` and `./arpent certificate check`, without the mission's name, e.g.
/// coverage_percent, certificate.valid_percent. Empty if the mission failed to run.
using TrialFigures = std::map<std::string, double>;

[[nodiscard]] std::vector<TrialFigures> run_trials(const std::vector<Trial>& trials);

struct MissionColumn {
  std::string name, unit, bar;
};
/// Adds BENCH.NAME and BENCH.NAME_std over the trials; collisions and unfinished are sums.
void add_mission_rows(Report& report, const std::string& bench, const std::vector<TrialFigures>& trials,
                      const std::vector<MissionColumn>& columns);

/// One mission with the seeds 1 to `seeds`, all columns that missions are judged by; `bars` by name.
void measure_mission(Report& report, const std::string& bench, const std::string& mission_file, int seeds,
                     const std::map<std::string, std::string>& bars);

}  // namespace arpent::bench
