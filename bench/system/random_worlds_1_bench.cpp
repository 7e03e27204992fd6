// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `random_worlds_1`: one robot in 20 worlds drawn at random, sensing depth: it touches nothing, ends by itself,
// and what it says about the surface that it left is true.
#include <fmt/format.h>
#include <unistd.h>

#include <fstream>

#include "bench/system/mission_trials.h"
#include "sim/world/random_world.h"

namespace arpent {
namespace {

constexpr int kWorlds = 20;

std::vector<bench::Trial> draw_trials(const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  std::vector<bench::Trial> trials(kWorlds);
  for (int i = 0; i < kWorlds; ++i) {
    bench::Trial& trial = trials[static_cast<std::size_t>(i)];
    trial.mission = ARPENT_SOURCE_DIR "/config/missions/test_arena.yaml";
    trial.overrides.world = folder / fmt::format("world_{}.yaml", i + 1);
    trial.overrides.seed = i + 1;
    trial.overrides.sensing = "depth";
    std::ofstream(trial.overrides.world) << sim::to_yaml(sim::make_random_world(static_cast<std::uint32_t>(i + 1)));
  }
  return trials;
}

}  // namespace
}  // namespace arpent

int main(int argc, char** argv) {
  using namespace arpent;
  return bench::run(argc, argv, "One robot in random worlds", [](bench::Report& report) {
    const auto folder = std::filesystem::temp_directory_path() / fmt::format("arpent_worlds_{}", getpid());
    bench::add_mission_rows(
        report, "random_worlds_1", bench::run_trials(draw_trials(folder)),
        {{"collisions", "1", "bar 0"},
         {"certificate.valid_percent", "%", "bar 100"},
         {"unfinished", "1", "bar 0: missions that did not end, and elements that could be completed"},
         {"done", "1", "of 20"},
         {"coverage_percent", "%", ""},
         {"time_s", "s", ""},
         {"path_m", "m", ""}});
    std::filesystem::remove_all(folder);
  });
}
