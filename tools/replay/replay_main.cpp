// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent replay LOG`: a log through depth, odometry and mapping, in lockstep or live; writes trajectory, mesh and
// report.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <opencv2/core.hpp>

#include "common/error.h"
#include "tools/replay/replay.h"
#include "tools/replay/summary.h"

namespace {

using namespace arpent;
using namespace arpent::tools;
namespace fs = std::filesystem;

struct Flags {
  std::string log, trajectory, frame, mesh, report, rig;
  std::vector<std::string> settings;
  std::vector<std::string> processes;
  bool live = false;
  ReplayOptions options;
};

void add_options(CLI::App& app, Flags& flags) {
  app.add_option("LOG", flags.log, "log with STEREO_IMAGES")->required();
  app.add_option("--trajectory", flags.trajectory, "write the estimated path (TUM), one row per pair");
  app.add_option("--trajectory-frame", flags.frame, "frame whose path is written (default: as the log says)")
      ->check(CLI::IsMember({"cam0", "body", "imu"}));
  app.add_option("--mesh", flags.mesh, "write the map's surface (PLY)");
  app.add_option("--report", flags.report, "folder for report.html, mesh.ply and trajectory.tum");
  app.add_option("--rig", flags.rig, "rig file instead of the log's own");
  app.add_option("--set", flags.settings, "key=value, overrides a parameter, e.g. mapping.tsdf.voxel_m=0.05");
  app.add_option("--start-s", flags.options.start_s, "seek: begin so many seconds into the log [s]");
  app.add_option("--duration-s", flags.options.duration_s, "play so many seconds [s]");
  app.add_option("--step", flags.options.step, "use each n-th pair")->check(CLI::Range(1, 1000));
  app.add_option("--speed", flags.options.speed, "live: speed of the player")->check(CLI::Range(0.01, 100.0));
  app.add_option("--only", flags.processes,
                 "run only these processes (depth, odometry, tag, pose, mapping); what the others publish comes from "
                 "the log")
      ->check(CLI::IsMember({"depth", "odometry", "tag", "pose", "mapping"}));
  app.add_option("--out-log", flags.options.out_log, "write everything published as a log");
  app.add_flag("--live", flags.live, "separate processes with lcm-logplayer and lcm-logger, compared with lockstep");
}

int replay(Flags flags, const fs::path& bin_folder) {
  cv::setNumThreads(1);
  const fs::path work = flags.report.empty() ? fs::temp_directory_path() / ("arpent_replay_" + std::to_string(getpid()))
                                             : fs::path(flags.report);
  ReplayInput input = open_log(flags.log, work, flags.rig, flags.settings);
  if (!flags.frame.empty()) input.config.trajectory_frame = flags.frame;
  if (!flags.processes.empty()) flags.options.processes = {flags.processes.begin(), flags.processes.end()};
  const ReplayResult lockstep = run_lockstep(input, flags.options);
  std::optional<ReplayResult> live;
  if (flags.live) {
    ReplayOptions live_options = flags.options;
    live_options.out_log.clear();
    live = run_live(input, live_options, bin_folder, work);
  }
  const Summary summary = summarise(input, lockstep, live ? &*live : nullptr);
  if (!flags.trajectory.empty())
    evaluation::write_tum(flags.trajectory, trajectory_of(lockstep, input, input.config.trajectory_frame));
  if (!flags.mesh.empty()) write_ply(flags.mesh, lockstep.mesh);
  if (!flags.report.empty()) write_replay_report(flags.report, input, lockstep, summary);
  print(summary);
  if (!flags.report.empty()) std::printf("report: %s\n", (fs::path(flags.report) / "report.html").c_str());
  if (flags.report.empty()) fs::remove_all(work);
  return live && !summary.difference->identical() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Replays a log of stereo pairs: depth, odometry, map; trajectory, mesh, report."};
  app.name("arpent replay");
  Flags flags;
  add_options(app, flags);
  try {
    app.parse(argc, argv);
    return replay(flags, fs::canonical("/proc/self/exe").parent_path());
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const InputError& error) {
    std::fprintf(stderr, "replay: %s\n", error.what());
    return 2;
  } catch (const fs::filesystem_error& error) {
    std::fprintf(stderr, "replay: %s\n", error.what());
    return 2;
  }
}
