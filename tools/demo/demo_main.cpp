// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent demo`: the main job from end to end, with nothing but the project itself. A simulated robot, or a team of
// them, reconstructs the test arena by itself: rendered images, depth, odometry, map, tours, drives over a mock CAN;
// then the report about it.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <opencv2/core.hpp>

#include "common/error.h"
#include "sim/world/world.h"
#include "tools/mission/figures.h"
#include "tools/mission/team_figures.h"

namespace {

using namespace arpent;
namespace fs = std::filesystem;

int show_robot(const tools::MissionSpec& spec, const tools::MissionOptions& options) {
  std::printf("1/2 a robot explores %s\n", spec.name.c_str());
  const tools::MissionResult result = tools::run_mission(spec, options);
  std::printf("2/2 what it was worth\n");
  const tools::MissionFigures figures = tools::measure(result);
  tools::write_mission_report(options.out, spec, result, figures);
  tools::print(figures, result);
  return tools::conclude("demo", options.out, result.done(), result.log_fault);
}

int show_team(const tools::MissionSpec& spec, const tools::MissionOptions& options) {
  std::printf("1/2 %d robots explore %s together\n", spec.robots, spec.name.c_str());
  const tools::TeamResult result = tools::run_team(spec, options);
  std::printf("2/2 what it was worth\n");
  const tools::TeamFigures figures = tools::measure(spec, result);
  tools::write_team_report(options.out, spec, result, figures);
  tools::print(figures);
  return tools::conclude("demo", options.out, figures.done, result.log_fault);
}

int run_demo(const fs::path& out, int seed, int robots, const std::string& sensing) {
  cv::setNumThreads(1);
  tools::MissionOverrides overrides;
  overrides.seed = seed;
  overrides.robots = robots;
  overrides.sensing = sensing;
  const tools::MissionSpec spec = tools::load_mission(ARPENT_SOURCE_DIR "/config/missions/test_arena.yaml", overrides);
  const std::size_t starts = sim::load_world(spec.world).starts.size();
  if (static_cast<std::size_t>(robots) > starts) {
    throw InputError("the test arena has room for " + std::to_string(starts) + " robots at its start, not for " +
                     std::to_string(robots) + "; config/missions/parking_lot.yaml takes more");
  }
  tools::MissionOptions options;
  options.out = out;
  return robots == 1 ? show_robot(spec, options) : show_team(spec, options);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "A simulated robot, or a team of them, reconstructs the test arena by itself; writes log, mesh and report."};
  app.name("arpent demo");
  std::string out = "out/demo";
  int seed = 1, robots = 1;
  std::string sensing = "images";
  app.add_option("--out", out, "folder for log, mesh and report")->capture_default_str();
  app.add_option("--seed", seed, "seed of all simulated noise")->capture_default_str();
  app.add_option("--robots", robots, "so many robots under one plan; the arena has room for three at its start")
      ->check(CLI::Range(1, 5))
      ->capture_default_str();
  app.add_option("--sensing", sensing, "images: cameras and all perception; depth: planning alone, ten times as fast")
      ->check(CLI::IsMember({"images", "depth"}))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    return run_demo(out, seed, robots, sensing);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "demo: %s\n", error.what());
    return 2;
  }
}
