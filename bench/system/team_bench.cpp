// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// bench `team`: what a team stands (`--sensing depth`): robots that die, random worlds, and the three ways of giving
// out work side by side.
#include <opencv2/core.hpp>
#include <random>

#include "bench/system/team_trials.h"
#include "common/atomic_file.h"
#include "common/bus/lockstep.h"
#include "common/channels.h"
#include "common/log/event_log.h"
#include "planning/process/centre_process.h"
#include "sim/world/random_world.h"
#include "sim/world/world.h"

namespace arpent::bench {
namespace {

namespace fs = std::filesystem;

constexpr int kDeaths = 10;
constexpr int kWorlds = 20;
/// A mission in a random world that is not done by then counts as a deadlock.
constexpr const char* kWorldTime = "mission.max_time_s=300";

TrialSpec depth_trial(const std::string& mission, int robots, int seed) {
  return {.mission = mission, .robots = robots, .seed = seed, .sensing = "depth"};
}

void compare_objectives(Report& report) {
  for (const std::string objective : {"time", "tsga", "nnb"}) {
    for (const auto& [mission, robots] : {std::pair("test_arena", 2), std::pair("parking_lot", 4)}) {
      TrialSpec spec = depth_trial(mission, robots, 1);
      spec.settings = {"centre.centre.allocation.objective=" + objective};
      add_means(report, "team." + objective + "." + mission + "_" + std::to_string(robots), {run_trial(spec)});
    }
  }
}

/// One of four dies at a random moment.
void lose_robots(Report& report) {
  std::mt19937 random(17);
  int done = 0;
  double change = 0;
  for (int seed = 1; seed <= kDeaths; ++seed) {
    TrialSpec spec = depth_trial("parking_lot", 4, seed);
    const Trial whole = run_trial(spec);
    spec.kill = "R" + std::to_string(1 + random() % 4) + "@" + std::to_string(10 + random() % 80);
    const Trial hurt = run_trial(spec);
    done += hurt.done ? 1 : 0;
    change += (hurt.coverage_percent - whole.coverage_percent) / kDeaths;
  }
  report.add("robot_loss.completed_percent", 100.0 * done / kDeaths, "%", "bar 100");
  report.add("robot_loss.coverage_change_points", change, "%", "bar >= -1");
}

/// The first worlds, by seed, with starts for five.
std::vector<fs::path> draw_worlds(const fs::path& folder) {
  std::vector<fs::path> worlds;
  for (std::uint32_t seed = 1; static_cast<int>(worlds.size()) < kWorlds; ++seed) {
    const sim::World world = sim::make_random_world(seed);
    if (world.starts.size() < 5) continue;
    worlds.push_back(folder / ("world_" + std::to_string(seed) + ".yaml"));
    atomic_write(worlds.back(), sim::to_yaml(world));
  }
  return worlds;
}

void try_random_worlds(Report& report) {
  const fs::path folder = fs::temp_directory_path() / "arpent_random_teams";
  fs::create_directories(folder);
  int collisions = 0, overlaps = 0, deadlocks = 0;
  for (const fs::path& world : draw_worlds(folder)) {
    for (const int robots : {2, 4, 5}) {
      TrialSpec spec = depth_trial("test_arena", robots, 1);
      spec.world = world;
      spec.settings = {kWorldTime};
      const Trial trial = run_trial(spec);
      collisions += trial.collisions;
      overlaps += trial.overlaps;
      deadlocks += trial.done ? 0 : 1;
    }
  }
  fs::remove_all(folder);
  report.add("random_teams.collisions", collisions, "1", "bar 0");
  report.add("random_teams.overlaps", overlaps, "1", "bar 0");
  report.add("random_teams.deadlocks", deadlocks, "1", "bar 0");
}

/// A centre that is started again with the journal of a whole mission behind it.
void restart_centre(Report& report) {
  const fs::path journal = fs::temp_directory_path() / "arpent_restart.lcmlog";
  fs::remove(journal);
  TrialSpec spec = depth_trial("parking_lot", 4, 1);
  spec.settings = {"centre.journal_file=" + journal.string()};
  (void)run_trial(spec);
  std::int64_t noted = 0;
  LogReader reader(journal);
  while (const auto event = reader.next()) noted += event->channel == channels::kTeamPatch ? 1 : 0;
  CentreConfig config = tools::load_mission(ARPENT_SOURCE_DIR "/config/missions/parking_lot.yaml", {}).centre;
  config.journal_file = journal;
  LockstepExecutor executor{Time(std::chrono::seconds(100))};
  const auto [bus, clock] = executor.add_process(CentreProcess::kName);
  std::unique_ptr<CentreProcess> centre;
  const double ms =
      cpu_ms([&, &bus = bus, &clock = clock] { centre = std::make_unique<CentreProcess>(config, bus, clock); });
  report.add("centre.restart_s", 1e-3 * ms, "s", "bar 5");
  report.add("centre.restart_patches_missing", static_cast<double>(noted - centre->centre().status().patches), "1",
             "bar 0");
  centre.reset();
  fs::remove(journal);
}

void measure(Report& report) {
  restart_centre(report);
  compare_objectives(report);
  lose_robots(report);
  try_random_worlds(report);
}

}  // namespace
}  // namespace arpent::bench

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  return arpent::bench::run(argc, argv, "team", arpent::bench::measure);
}
