// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/live.h"

#include <fmt/format.h>

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

constexpr std::size_t kProgressSteps = 1000;

volatile std::sig_atomic_t g_interrupted = 0;  // set by the signal handler only

/// What the running processes say.
class Ear {
 public:
  explicit Ear(const std::string& url) : bus_(url) {
    subscribe<health_t>(bus_, channels::kHealth, {.queue_capacity = 100}, [this](const health_t& health) {
      ProcessFigures& figures = figures_[health.process];
      for (const auto& counter : health.counters) figures.counters[counter.name] = counter.value;
      if (!health.message.empty()) figures.messages.emplace_back(health.message, 1);
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
  [[nodiscard]] bool ended() const {
    return report_ &&
           (report_->state == planning::MissionState::kDone || report_->state == planning::MissionState::kAborted);
  }

 private:
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

/// A process that is given up ends the mission: nobody else does its work.
void watch(Launcher& launcher, const fs::path& launch_log) {
  launcher.poll(10);
  for (const Launcher::Child& child : launcher.children()) {
    if (child.gave_up) throw InputError(child.spec.name + " ends again and again; see " + launch_log.string());
  }
}

void wait_until_all_speak(Ear& ear, Launcher& launcher, std::size_t count, const fs::path& launch_log) {
  const auto limit = Steady::now() + 30s;
  while (ear.figures().size() < count && Steady::now() < limit && !interrupted()) {
    watch(launcher, launch_log);
    ear.listen(100ms);
  }
  if (ear.figures().size() < count) throw InputError("not all processes came up; see " + launch_log.string());
}

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
  if (const std::string shared = enter_private_network(); !shared.empty()) std::fprintf(stderr, "%s\n", shared.c_str());
  const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=4194304", private_port());
  MissionSpec spec = given;
  spec.mapping.mesh_file = fs::absolute(options.out / "live_mesh.ply");
  const fs::path raw = options.out / "live.lcmlog";
  std::error_code ignored;
  fs::remove(raw, ignored);
  fs::remove(spec.mapping.mesh_file, ignored);
  const fs::path launch_log = options.out / "launch.log";
  Launcher launcher(launch_log);
  Ear ear(url);
  launcher.start({"logger", {"lcm-logger", "--lcm-url=" + url, "-f", raw.string()}, false});
  const std::vector<Member> members = members_of(spec);
  for (const Member& member : members) {
    const fs::path file = options.out / (member.name + ".yaml");
    atomic_write(file, member.yaml);
    launcher.start({member.name,
                    {(options.bin_folder / member.name).string(), "--config", file.string(), "--lcm-url", url},
                    true});
  }
  wait_until_all_speak(ear, launcher, members.size(), launch_log);
  ear.send_start();
  while (!ear.ended() && !interrupted()) {
    watch(launcher, launch_log);
    ear.listen(200ms);
    if (ear.report() && options.progress) {
      show_progress(ear.report()->activity, static_cast<std::size_t>(ear.report()->progress * kProgressSteps),
                    kProgressSteps);
    }
  }
  ear.listen(1000ms);
  for (auto member = members.rbegin(); member != members.rend(); ++member) launcher.stop(member->name, 20000);
  ear.listen(300ms);
  launcher.stop_all(5000);

  MissionResult result;
  result.log = options.out / "mission.lcmlog";
  finish_log(raw, result, spec);
  result.processes = ear.figures();
  const auto contacts = result.processes[SimProcess::kName].counters.find("WORLD.collision");
  if (contacts != result.processes[SimProcess::kName].counters.end()) {
    result.collisions = static_cast<int>(contacts->second);
  }
  if (fs::exists(spec.mapping.mesh_file)) result.mesh = read_ply(spec.mapping.mesh_file);
  result.wall_s = std::chrono::duration<double>(Steady::now() - wall_start).count();
  return result;
}

}  // namespace arpent::tools
