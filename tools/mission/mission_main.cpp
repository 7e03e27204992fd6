// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent mission FILE`: runs a mission in simulation, once or over several seeds, and writes log, figures and
// report.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <opencv2/core.hpp>

#include "common/error.h"
#include "tools/mission/figures.h"
#include "tools/mission/team_figures.h"

namespace {

using namespace arpent;
using namespace arpent::tools;
namespace fs = std::filesystem;

struct Flags {
  std::string file, out;
  MissionOverrides overrides;
  std::optional<int> seed;
  int trials = 1, jobs = 1;
  bool live = false;
};

void add_options(CLI::App& app, Flags& flags) {
  app.add_option("FILE", flags.file, "mission file (config/missions)")->required();
  app.add_option("--world", flags.overrides.world, "world file instead of the mission's");
  app.add_option("--rig", flags.overrides.rig,
                 "rig file that perception believes in; the simulator's cameras stay as the robot's rig file says");
  app.add_option("--seed", flags.seed, "seed of all simulated noise");
  app.add_option("--trials", flags.trials, "so many runs with seeds one after the other")->check(CLI::Range(1, 10000));
  app.add_option("--jobs", flags.jobs, "runs at the same time")->check(CLI::Range(1, 64));
  app.add_option("--sensing", flags.overrides.sensing, "images: cameras and all perception; depth: for planning alone")
      ->check(CLI::IsMember({"images", "depth"}));
  app.add_option("--preset", flags.overrides.preset, "default, or thesis: its method as printed")
      ->check(CLI::IsMember({"default", "thesis"}));
  app.add_option("--robots", flags.overrides.robots, "so many robots under one plan")->check(CLI::Range(1, 5));
  app.add_option("--kill", flags.overrides.kill, "ROBOT@SECONDS: a robot's computer dies, e.g. R2@40; or centre@40");
  app.add_option("--join", flags.overrides.join,
                 "ROBOT@SECONDS: a robot joins late, e.g. R3@30; centre@45: the centre that was killed starts again");
  app.add_flag("--live", flags.live, "separate processes in real time instead of lockstep");
  app.add_option("--set", flags.overrides.settings,
                 "key=value, overrides a parameter, e.g. pose.fusion.gyro.used=false");
  app.add_option("--out", flags.out, "folder for log, figures and report (default: out/NAME)");
}

/// The exit code: as conclude() says.
int run_one(const Flags& flags, int seed, const fs::path& out, int threads, bool progress) {
  MissionOverrides overrides = flags.overrides;
  overrides.seed = seed;
  const MissionSpec spec = load_mission(flags.file, overrides);
  MissionOptions options;
  options.out = out;
  options.threads = threads;
  options.live = flags.live;
  options.bin_folder = fs::canonical("/proc/self/exe").parent_path();
  options.progress = progress;
  if (spec.robots > 1) {
    const TeamResult team = run_team(spec, options);
    const TeamFigures team_figures = measure(spec, team);
    write_team_report(out, spec, team, team_figures);
    std::printf("seed             %d\n", seed);
    print(team_figures);
    return conclude("mission", out, team_figures.done, team.log_fault);
  }
  const MissionResult result = run_mission(spec, options);
  const MissionFigures figures = measure(result);
  write_mission_report(out, spec, result, figures);
  std::printf("seed             %d\n", seed);
  print(figures, result);
  return conclude("mission", out, result.done(), result.log_fault);
}

/// Each trial in a process of its own, `jobs` at a time.
int run_trials(const Flags& flags, int first_seed, const fs::path& out) {
  int failed = 0, running = 0;
  const auto reap = [&] {
    int status = 0;
    if (wait(&status) < 0) return;
    --running;
    failed += WIFEXITED(status) && WEXITSTATUS(status) == 0 ? 0 : 1;
  };
  for (int i = 0; i < flags.trials; ++i) {
    while (running >= flags.jobs) reap();
    std::fflush(nullptr);
    const pid_t child = fork();
    if (child == 0) {
      int code = 2;
      try {
        const int seed = first_seed + i;
        code = run_one(flags, seed, out / fmt::format("seed_{}", seed), 1, flags.jobs == 1);
      } catch (const std::exception& error) {
        std::fprintf(stderr, "mission: %s\n", error.what());
      }
      std::fflush(nullptr);
      _exit(code);
    }
    running += child > 0 ? 1 : 0;
    failed += child > 0 ? 0 : 1;
  }
  while (running > 0) reap();
  std::printf("%d of %d missions done\n", flags.trials - failed, flags.trials);
  return failed == 0 ? 0 : 1;
}

int run(const Flags& flags) {
  cv::setNumThreads(1);
  const MissionSpec spec = load_mission(flags.file, flags.overrides);
  const fs::path out = flags.out.empty() ? fs::path("out") / spec.name : fs::path(flags.out);
  const int seed = flags.seed.value_or(spec.seed);
  return flags.trials == 1 ? run_one(flags, seed, out, 2, true) : run_trials(flags, seed, out);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Runs a mission in simulation, and writes log, figures and report."};
  app.name("arpent mission");
  Flags flags;
  add_options(app, flags);
  try {
    app.parse(argc, argv);
    return run(flags);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "mission: %s\n", error.what());
    return 2;
  }
}
