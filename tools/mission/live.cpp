// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/live.h"

#include <fmt/format.h>

#include <chrono>
#include <csignal>

#include "common/error.h"
#include "common/net/private_network.h"
#include "tools/mission/live_bus.h"
#include "tools/progress.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

volatile std::sig_atomic_t g_interrupted = 0;  // set by the signal handler only

/// The run's processes, from their start to their end.
class LiveRun {
 public:
  LiveRun(const MissionSpec& spec, const MissionOptions& options, const std::string& url)
      : log_(options.out / "launch.log"), launcher_(log_), bus_({"", options.out, url}, launcher_, options.bin_folder) {
    // A world that starts anew would put the robot back: the end of the simulator is the end of the run.
    for (const Member& member : robot_members(spec)) bus_.start(member, member.name != SimProcess::kName);
    bus_.start({MappingProcess::kName, config::to_yaml(spec.mapping)}, true);
    bus_.start({MissionProcess::kName, config::to_yaml(spec.mission)}, true);
  }

  /// Waits until every process speaks; false if interrupted.
  bool come_up() {
    const auto limit = Steady::now() + kComeUp;
    while (!bus_.silent().empty() && !interrupted()) {
      if (Steady::now() > limit) throw InputError(bus_.silent() + " does not come up; see " + log_.string());
      listen(100ms);
    }
    return !interrupted();
  }

  /// Starts the mission and sees it to its end, or as far as it comes in `limit_s`.
  void drive(double limit_s, bool progress) {
    const auto limit = Steady::now() + std::chrono::duration<double>(limit_s);
    while (!bus_.ear().ended() && !interrupted()) {
      if (Steady::now() > limit) throw InputError("the mission does not end; see " + log_.string());
      bus_.ear().start_mission();
      listen(200ms);
      const auto& report = bus_.ear().report();
      if (report && progress) {
        show_progress(report->activity, static_cast<std::size_t>(report->progress * kProgressSteps), kProgressSteps);
      }
    }
  }

  /// The mission first, the simulator last, then the logger, which has heard all of them.
  void end() {
    bus_.ear().listen(1000ms);
    launcher_.restart_no_more();
    for (auto name = bus_.names().rbegin(); name != bus_.names().rend(); ++name) launcher_.stop(*name, 20000);
    bus_.ear().listen(300ms);
    launcher_.stop_all(5000);
  }

  [[nodiscard]] const LiveBus& bus() const { return bus_; }

 private:
  void listen(std::chrono::milliseconds time) {
    watch(launcher_, log_);
    bus_.ear().listen(time);
  }

  fs::path log_;
  Launcher launcher_;
  LiveBus bus_;
};

}  // namespace

bool interrupted() {
  static const bool listening = [] {
    const auto on_signal = [](int) { g_interrupted = 1; };
    std::signal(SIGINT, on_signal);
    std::signal(SIGTERM, on_signal);
    return true;
  }();
  return listening && g_interrupted != 0;
}

MissionResult run_live_mission(const MissionSpec& given, const MissionOptions& options) {
  const auto wall_start = Steady::now();
  (void)interrupted();  // from here on Ctrl-C is an orderly end
  if (const std::string shared = enter_private_network(); !shared.empty()) {
    std::fprintf(stderr, "mission: no network of its own (%s): the port is its own\n", shared.c_str());
  }
  const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", private_port());
  MissionSpec spec = given;
  spec.mapping.mesh_file = fs::absolute(options.out / "live_mesh.ply");
  std::error_code ignored;
  fs::remove(spec.mapping.mesh_file, ignored);
  LiveRun run(spec, options, url);
  if (run.come_up()) run.drive(spec.mission.max_time_s + kPatienceS, options.progress);
  run.end();

  MissionResult result;
  result.log = options.out / "mission.lcmlog";
  finish_log(run.bus().raw_log(), result, spec);
  result.processes = run.bus().figures();
  const auto contacts = result.processes[SimProcess::kName].counters.find("WORLD.collision");
  if (contacts != result.processes[SimProcess::kName].counters.end()) {
    result.collisions = static_cast<int>(contacts->second);
  }
  if (fs::exists(spec.mapping.mesh_file)) result.mesh = read_ply(spec.mapping.mesh_file);
  fs::remove(spec.mapping.mesh_file, ignored);
  result.wall_s = std::chrono::duration<double>(Steady::now() - wall_start).count();
  return result;
}

}  // namespace arpent::tools
