// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/live_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <arpent/health_t.hpp>

#include "common/atomic_file.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/net/radio_network.h"
#include "tools/mission/live.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using Steady = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr char kLogger[] = "lcm-logger";

void count_message(ProcessFigures& figures, const std::string& text) {
  const auto known = std::find_if(figures.messages.begin(), figures.messages.end(),
                                  [&](const auto& message) { return message.first == text; });
  if (known == figures.messages.end()) {
    figures.messages.emplace_back(text, 1);
  } else {
    ++known->second;
  }
}

}  // namespace

Ear::Ear(const std::string& url) : bus_(url) {
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

void Ear::listen(std::chrono::milliseconds time) {
  for (const auto until = Steady::now() + time; Steady::now() < until;) {
    bus_.run_for(std::min<Duration>(20ms, std::chrono::duration_cast<Duration>(until - Steady::now())));
  }
}

void Ear::start_mission() {
  if (report_ && report_->state != planning::MissionState::kWaiting) return;
  publish(bus_, channels::kMissionCommand,
          planning::to_wire(bus_.now(), {planning::MissionCommand::kStart, "mission"}));
}

std::vector<Member> robot_members(const MissionSpec& spec) {
  std::vector<Member> members{{SimProcess::kName, config::to_yaml(spec.sim)},
                              {BaseDriverProcess::kName, config::to_yaml(spec.base)}};
  if (spec.sensing == "images") {
    members.push_back({DepthProcess::kName, config::to_yaml(spec.depth)});
    members.push_back({OdometryProcess::kName, config::to_yaml(spec.odometry)});
    members.push_back({TagProcess::kName, config::to_yaml(spec.tags)});
  }
  members.push_back({PoseProcess::kName, config::to_yaml(spec.pose)});
  members.push_back({TrackerProcess::kName, config::to_yaml(spec.tracker)});
  return members;
}

LiveBus::LiveBus(const LiveBusPlace& place, Launcher& launcher, const fs::path& bin_folder)
    : place_(place), launcher_(launcher), bin_folder_(bin_folder), raw_(place.folder / "live.lcmlog") {
  fs::create_directories(place_.folder);
  std::error_code ignored;
  fs::remove(raw_, ignored);
  launcher_.start({place_.name + kLogger,
                   {kLogger, "--lcm-url=" + place_.url, "-q", "-f", raw_.string()},
                   false,
                   place_.network_fd});
  run_in_network(place_.network_fd, [this] { ear_ = std::make_unique<Ear>(place_.url); });
}

void LiveBus::start(const Member& member, bool restart) {
  const fs::path file = place_.folder / (member.name + ".yaml");
  atomic_write(file, member.yaml);
  launcher_.start({place_.name + member.name,
                   {(bin_folder_ / member.name).string(), "--config", file.string(), "--lcm-url", place_.url},
                   restart,
                   place_.network_fd});
  names_.push_back(place_.name + member.name);
}

std::string LiveBus::silent() const {
  for (const std::string& name : names_) {
    if (ear_->figures().count(name.substr(place_.name.size())) == 0) return name;
  }
  return "";
}

std::map<std::string, ProcessFigures> LiveBus::figures() const {
  std::map<std::string, ProcessFigures> figures;
  for (const auto& [process, said] : ear_->figures()) figures[place_.name + process] = said;
  for (const Launcher::Child& child : launcher_.children()) {
    if (child.restarts == 0 || std::find(names_.begin(), names_.end(), child.spec.name) == names_.end()) continue;
    figures[child.spec.name].messages.emplace_back("ended and was started again", child.restarts);
  }
  return figures;
}

void watch(Launcher& launcher, const fs::path& log) {
  launcher.poll(10);
  for (const Launcher::Child& child : launcher.children()) {
    if (child.killed || !(child.gave_up || (child.pid < 0 && !child.spec.restart))) continue;
    throw InputError(fmt::format("{} ended with code {}; see {}", child.spec.name, child.exit_code, log.string()));
  }
}

void finish_log(const fs::path& raw, MissionResult& result, const MissionSpec& spec) {
  LogReader reader(raw);
  LogWriter log(result.log);
  MissionCollector collector(result, &log);
  bool first = true;
  while (const auto event = reader.next()) {
    if (std::exchange(first, false)) write_configs(log, event->time, spec);
    collector.take(event->time, event->channel, event->data);
  }
  collector.close();
  if (result.log_fault.empty()) fs::remove(raw);
}

}  // namespace arpent::tools
