// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent demo`: the main job from end to end, with nothing but the project itself. A simulated robot reconstructs
// the test arena by itself: rendered images, depth, odometry, map, tours, drives over a mock CAN; then the report about
// it.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <opencv2/core.hpp>

#include "common/error.h"
#include "tools/mission/figures.h"

namespace {

using namespace arpent;
namespace fs = std::filesystem;

int run_demo(const fs::path& out, int seed) {
  cv::setNumThreads(1);
  tools::MissionOverrides overrides;
  overrides.seed = seed;
  const tools::MissionSpec spec = tools::load_mission(ARPENT_SOURCE_DIR "/config/missions/test_arena.yaml", overrides);
  tools::MissionOptions options;
  options.out = out;
  std::printf("1/2 a robot explores %s\n", spec.name.c_str());
  const tools::MissionResult result = tools::run_mission(spec, options);
  std::printf("2/2 what it was worth\n");
  const tools::MissionFigures figures = tools::measure(result);
  tools::write_mission_report(out, spec, result, figures);
  tools::print(figures, result);
  std::printf("report           %s\n", fs::absolute(out / "report.html").c_str());
  return result.done() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"A simulated robot reconstructs the test arena by itself; writes log, mesh and report."};
  app.name("arpent demo");
  std::string out = "out/demo";
  int seed = 1;
  app.add_option("--out", out, "folder for log, mesh and report")->capture_default_str();
  app.add_option("--seed", seed, "seed of all simulated noise")->capture_default_str();
  try {
    app.parse(argc, argv);
    return run_demo(out, seed);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "demo: %s\n", error.what());
    return 2;
  }
}
