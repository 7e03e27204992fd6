// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `mission_arena_2`, `mission_lot_2`, `mission_lot_4`: a team reconstructs the arena or the parking lot with
// images in the loop, over a radio with 2 % loss and 20 ms delay, three seeds. `mission_lot_4` also runs one robot
// alone, for the speed-up.
#include <opencv2/core.hpp>

#include "bench/system/team_trials.h"

namespace arpent::bench {
namespace {

constexpr int kSeeds = 3;

std::vector<Trial> run_seeds(const std::string& mission, int robots) {
  std::vector<Trial> trials;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    trials.push_back(run_trial({.mission = mission, .robots = robots, .seed = seed}));
  }
  return trials;
}

void measure(Report& report) {
  const std::vector<Trial> team = run_seeds(ARPENT_BENCH_MISSION, ARPENT_BENCH_ROBOTS);
  const std::string name = ARPENT_BENCH_NAME;
  add_means(report, name, team);
  if (name != "mission_lot_4") return;
  const std::vector<Trial> alone = run_seeds(ARPENT_BENCH_MISSION, 1);
  report.add(name + ".speedup", mean_of(alone, &Trial::time_s) / mean_of(team, &Trial::time_s), "1", "bar >= 2.0");
  report.add(name + ".coverage_gain_over_1",
             mean_of(team, &Trial::coverage_percent) - mean_of(alone, &Trial::coverage_percent), "%", "bar >= -1");
}

}  // namespace
}  // namespace arpent::bench

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  return arpent::bench::run(argc, argv, ARPENT_BENCH_NAME, arpent::bench::measure);
}
