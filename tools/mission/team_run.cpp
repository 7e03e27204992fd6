// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/team_run.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <set>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/robot.h"
#include "common/cpu_time.h"
#include "common/error.h"
#include "common/memory.h"
#include "mapping/surface/mesh_extraction.h"
#include "tools/mission/disk_reserve.h"
#include "tools/mission/encounters.h"
#include "tools/mission/live.h"
#include "tools/mission/lockstep.h"
#include "tools/mission/team_live.h"
#include "tools/progress.h"

namespace arpent::tools {
namespace {

/// What one robot's bus says, into its log and result.
struct Listener {
  std::unique_ptr<LogWriter> log;
  std::unique_ptr<MissionCollector> collector;
};

class TeamRun {
 public:
  TeamRun(const MissionSpec& spec, const MissionOptions& options)
      : spec_(spec),
        deaths_(deaths(spec)),
        joins_(joins(spec)),
        reserve_(options.out),
        stack_(kStart, options.threads) {
    result_.names = robot_names(spec);
    sims_.resize(result_.names.size());
    result_.robots.resize(result_.names.size());
    for (std::size_t i = 0; i < result_.names.size(); ++i) {
      listen(options.out / result_.names[i], spec_of_robot(spec, static_cast<int>(i)), result_.robots[i]);
      if (!joins_late(result_.names[i])) begin(i);
    }
    std::filesystem::create_directories(options.out / kCentre);
    centre_log_ = std::make_unique<LogWriter>(options.out / kCentre / "mission.lcmlog");
    centre_config_ = spec.centre;
    if (!deaths_.empty()) {
      centre_config_.journal_file = options.out / kCentre / "journal.lcmlog";
      std::filesystem::remove(centre_config_.journal_file);
    }
    centre_ = &stack_.add<CentreProcess>(centre_config_, std::string(kCentre) + "/");
    add_radio();
    stack_.executor().set_tap(
        [this](Time time, const std::string& channel, BytesView bytes) { take(time, channel, bytes); });
  }

  TeamResult run(bool progress) {
    while (!all_ended() && !interrupted()) {
      for (const TeamEvent& death : deaths_) kill(death);
      for (const TeamEvent& join : joins_) admit(join);
      stack_.executor().run_until(stack_.executor().now() + kStep);
      const auto refused = [](const Listener& l) { return l.collector->log_was_refused(); };
      if (std::ranges::any_of(listeners_, refused)) reserve_.log_was_refused();
      if (progress) show();
    }
    stack_.executor().run_until(stack_.executor().now() + kRunOut);
    stack_.finish();
    stack_.executor().run_until(stack_.executor().now() + kStep);
    gather();
    return std::move(result_);
  }

 private:
  void listen(const std::filesystem::path& folder, const MissionSpec& robot, MissionResult& result) {
    std::filesystem::create_directories(folder);
    result.log = folder / "mission.lcmlog";
    Listener listener;
    listener.log = std::make_unique<LogWriter>(result.log);
    write_configs(*listener.log, kStart, robot);
    listener.collector = std::make_unique<MissionCollector>(result, listener.log.get());
    listeners_.push_back(std::move(listener));
  }

  [[nodiscard]] bool joins_late(const std::string& name) const {
    return std::any_of(joins_.begin(), joins_.end(), [&](const TeamEvent& join) { return join.who == name; });
  }

  /// The robot's processes, and its order to start.
  void begin(std::size_t i) {
    const MissionSpec robot = spec_of_robot(spec_, static_cast<int>(i));
    const std::string prefix = result_.names[i] + "/";
    sims_[i] = &add_robot(stack_, robot, prefix);
    stack_.add<PatchProcess>(robot.patch, prefix);
    stack_.add<MissionProcess>(robot.mission, prefix);
    const Time now = stack_.executor().now();
    stack_.executor().inject(now + kStartAfter, prefix + channels::kMissionCommand,
                             encode(planning::to_wire(now, {planning::MissionCommand::kStart, "mission"})));
  }

  void add_radio() {
    RadioConfig radio = spec_.radio;
    radio.robots.clear();
    for (const std::string& name : result_.names) radio.robots += (radio.robots.empty() ? "" : ",") + name;
    radio.centre = kCentre;
    radio.seed = spec_.seed;
    radio_ = &stack_.add<RadioProcess>(radio);
  }

  void take(Time time, const std::string& channel, BytesView bytes) {
    const std::size_t slash = channel.find('/');
    const std::string bus = channel.substr(0, slash), name = channel.substr(slash + 1);
    if (bus == kCentre) {
      centre_log_->write(time, name, bytes);
      return;
    }
    const auto robot = std::find(result_.names.begin(), result_.names.end(), bus) - result_.names.begin();
    listeners_[static_cast<std::size_t>(robot)].collector->take(time, name, bytes);
  }

  [[nodiscard]] bool all_ended() const {
    for (std::size_t i = 0; i < result_.names.size(); ++i) {
      if (sims_[i] != nullptr && !killed_.contains(result_.names[i]) && !result_.robots[i].ended()) return false;
    }
    return true;
  }

  [[nodiscard]] bool is_due(const TeamEvent& event) {
    return stack_.executor().now() >= kStart + kStartAfter + from_seconds(event.at_s);
  }

  void kill(const TeamEvent& death) {
    if (!is_due(death) || !killed_.insert(death.who).second) return;
    stack_.executor().silence(death.who + "/", SimProcess::kName);
    if (death.who != kCentre) result_.died.push_back(death.who);
  }

  void admit(const TeamEvent& join) {
    if (!is_due(join) || !admitted_.insert(join.who).second) return;
    if (join.who == kCentre) {
      centre_ = &stack_.add<CentreProcess>(centre_config_, std::string(kCentre) + "/");
    } else {
      begin(static_cast<std::size_t>(std::find(result_.names.begin(), result_.names.end(), join.who) -
                                     result_.names.begin()));
    }
  }

  void show() const {
    std::string activity;
    double progress = 0;
    for (const MissionResult& robot : result_.robots) {
      if (robot.reports.empty()) continue;
      activity += (activity.empty() ? "" : " | ") + robot.reports.back().activity.substr(0, 24);
      progress = std::max(progress, robot.reports.back().progress);
    }
    show_progress(activity, static_cast<std::size_t>(progress * kProgressSteps), kProgressSteps);
  }

  void gather() {
    for (std::size_t i = 0; i < result_.robots.size(); ++i) {
      listeners_[i].collector->close();
      result_.robots[i].collisions = sims_[i] != nullptr ? sims_[i]->collisions() : 0;
    }
    result_.log_fault = close_log(*centre_log_);
    for (const MissionResult& robot : result_.robots) {
      if (!robot.log_fault.empty()) result_.log_fault = robot.log_fault;
    }
    result_.mesh = mapping::extract_mesh(centre_->centre().map());
    result_.centre = centre_->centre().status();
    result_.radio_bytes = radio_->bytes_by_channel();
    result_.processes = stack_.figures();
    std::vector<evaluation::Trajectory> truths;
    for (const MissionResult& robot : result_.robots) truths.push_back(robot.truth);
    result_.encounters = encounters_of(config::load<RobotConfig>(spec_.robot), truths);
  }

  const MissionSpec& spec_;
  std::vector<TeamEvent> deaths_, joins_;
  DiskReserve reserve_;
  TeamResult result_;
  std::vector<Listener> listeners_;
  std::unique_ptr<LogWriter> centre_log_;
  LockstepStack stack_;
  std::vector<const SimProcess*> sims_;  ///< null: the robot has not joined
  CentreConfig centre_config_;
  std::set<std::string> killed_, admitted_;
  const CentreProcess* centre_ = nullptr;
  const RadioProcess* radio_ = nullptr;
};

}  // namespace

TeamResult run_team(const MissionSpec& spec, const MissionOptions& options) {
  if (spec.mission.kind != "explore") throw InputError("a team explores; mission.kind must be explore");
  if (options.live) return run_live_team(spec, options);
  keep_freed_memory();
  const double cpu_start = process_cpu_s();
  const auto wall_start = std::chrono::steady_clock::now();
  TeamResult result = TeamRun(spec, options).run(options.progress);
  result.cpu_s = process_cpu_s() - cpu_start;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  return result;
}

}  // namespace arpent::tools
