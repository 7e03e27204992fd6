// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/live.h"

#include <fmt/format.h>

#include <algorithm>
#include <arpent/health_t.hpp>
#include <chrono>
#include <csignal>

#include "common/atomic_file.h"
#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/net/private_network.h"
#include "tools/launch/launcher.h"
#include "tools/progress.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto kComeUp = 30s;
/// The mission's own limit ends it; this much later it is ended from outside.
constexpr double kPatienceS = 30;
constexpr char kLogger[] = "lcm-logger";

volatile std::sig_atomic_t g_interrupted = 0;  // set by the signal handler only

/// What the running processes say.
class Ear {
 public:
  explicit Ear(const std::string& url) : bus_(url) {
    subscribe<health_t>(bus_, channels::kHealth, {.queue_capacity = 100}, [this](const health_t& health) {
      ProcessFigures& figures = figures_[health.process];
      for (const auto& counter : health.counters) figures.counters[counter.name] = counter.value;
      if (!health.message.empty()) count_message(figures, health.message);
    });
    subscribe<mission_state_t>(bus_, channels::kMissionState, {}, [this](const mission_state_t& message) {
      if (const auto report = planning::from_wire(message)) report_ = *report;
    });
    bus_.start();
  }
  void listen(std::chrono::milliseconds time) {
    const auto until = Steady::now() + time;
    while (Steady::now() < until) bus_.run_for(20ms);
  }
  void send_start() {
    publish(bus_, channels::kMissionCommand,
            planning::to_wire(bus_.now(), {planning::MissionCommand::kStart, "mission"}));
  }
  [[nodiscard]] const std::optional<planning::MissionReport>& report() const { return report_; }
  [[nodiscard]] const std::map<std::string, ProcessFigures>& figures() const { return figures_; }
  [[nodiscard]] bool ended() const { return report_ && has_ended(*report_); }

 private:
  static void count_message(ProcessFigures& figures, const std::string& text) {
    const auto known = std::find_if(figures.messages.begin(), figures.messages.end(),
                                    [&](const auto& message) { return message.first == text; });
    if (known == figures.messages.end()) {
      figures.messages.emplace_back(text, 1);
    } else {
      ++known->second;
    }
  }

  LcmBus bus_;
  std::map<std::string, ProcessFigures> figures_;
  std::optional<planning::MissionReport> report_;
};

struct Member {
  std::string name;
  std::string yaml;
};

std::vector<Member> members_of(const MissionSpec& spec) {
  std::vector<Member> members{{SimProcess::kName, config::to_yaml(spec.sim)},
                              {BaseDriverProcess::kName, config::to_yaml(spec.base)}};
  if (spec.sensing == "images") {
    members.push_back({DepthProcess::kName, config::to_yaml(spec.depth)});
    members.push_back({OdometryProcess::kName, config::to_yaml(spec.odometry)});
    members.push_back({TagProcess::kName, config::to_yaml(spec.tags)});
  }
  members.push_back({PoseProcess::kName, config::to_yaml(spec.pose)});
  members.push_back({TrackerProcess::kName, config::to_yaml(spec.tracker)});
  members.push_back({MappingProcess::kName, config::to_yaml(spec.mapping)});
  members.push_back({MissionProcess::kName, config::to_yaml(spec.mission)});
  return members;
}

/// The run's processes, from their start to their end.
class LiveRun {
 public:
  LiveRun(const MissionSpec& spec, const MissionOptions& options, const std::string& url)
      : log_(options.out / "launch.log"), launcher_(log_), members_(members_of(spec)), ear_(url) {
    raw_ = options.out / "live.lcmlog";
    std::error_code ignored;
    fs::remove(raw_, ignored);
    launcher_.start({kLogger, {kLogger, "--lcm-url=" + url, "-q", "-f", raw_.string()}, false});
    for (const Member& member : members_) {
      const fs::path file = options.out / (member.name + ".yaml");
      atomic_write(file, member.yaml);
      // A world that starts anew would put the robot back: the end of the simulator is the end of the run.
      const bool restart = member.name != SimProcess::kName;
      launcher_.start({member.name,
                       {(options.bin_folder / member.name).string(), "--config", file.string(), "--lcm-url", url},
                       restart});
    }
  }

  /// Waits until every process speaks; false if interrupted.
  bool come_up() {
    const auto limit = Steady::now() + kComeUp;
    while (!silent().empty() && !interrupted()) {
      if (Steady::now() > limit) throw InputError(silent() + " does not come up; see " + log_.string());
      listen(100ms);
    }
    return !interrupted();
  }

  /// Starts the mission and sees it to its end, or as far as it comes in `limit_s`.
  void drive(double limit_s, bool progress) {
    const auto limit = Steady::now() + std::chrono::duration<double>(limit_s);
    while (!ear_.ended() && !interrupted()) {
      if (Steady::now() > limit) throw InputError("the mission does not end; see " + log_.string());
      // A start can be lost on the way; a second one is refused.
      if (!ear_.report() || ear_.report()->state == planning::MissionState::kWaiting) ear_.send_start();
      listen(200ms);
      if (ear_.report() && progress) {
        show_progress(ear_.report()->activity, static_cast<std::size_t>(ear_.report()->progress * kProgressSteps),
                      kProgressSteps);
      }
    }
  }

  /// The mission first, the simulator last, then the logger, which has heard all of them.
  void end() {
    ear_.listen(1000ms);
    launcher_.restart_no_more();
    for (auto member = members_.rbegin(); member != members_.rend(); ++member) launcher_.stop(member->name, 20000);
    ear_.listen(300ms);
    launcher_.stop_all(5000);
  }

  [[nodiscard]] const fs::path& raw_log() const { return raw_; }
  /// What the processes said of themselves, and how often one had to be started again.
  [[nodiscard]] std::map<std::string, ProcessFigures> figures() const {
    auto figures = ear_.figures();
    for (const Launcher::Child& child : launcher_.children()) {
      if (child.restarts > 0)
        figures[child.spec.name].messages.emplace_back("ended and was started again", child.restarts);
    }
    return figures;
  }

 private:
  /// A process that nobody starts again ends the run.
  void watch() {
    launcher_.poll(10);
    for (const Launcher::Child& child : launcher_.children()) {
      if (child.gave_up || (child.pid < 0 && !child.spec.restart)) {
        throw InputError(fmt::format("{} ended with code {}; see {}", child.spec.name, child.exit_code, log_.string()));
      }
    }
  }
  void listen(std::chrono::milliseconds time) {
    watch();
    ear_.listen(time);
  }
  /// The first process that has not been heard.
  [[nodiscard]] std::string silent() const {
    for (const Member& member : members_) {
      if (ear_.figures().count(member.name) == 0) return member.name;
    }
    return "";
  }

  fs::path log_, raw_;
  Launcher launcher_;
  std::vector<Member> members_;
  Ear ear_;
};

/// The log of lcm-logger, with the CONFIG events before it and images compressed.
void finish_log(const fs::path& raw, MissionResult& result, const MissionSpec& spec) {
  LogReader reader(raw);
  LogWriter log(result.log);
  MissionCollector collector(result, &log);
  bool first = true;
  while (const auto event = reader.next()) {
    if (std::exchange(first, false)) write_configs(log, event->time, spec);
    collector.take(event->time, event->channel, event->data);
  }
  log.close();
  fs::remove(raw);
}

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
  finish_log(run.raw_log(), result, spec);
  result.processes = run.figures();
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
