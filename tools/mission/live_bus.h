// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What live missions have in common, of one robot (live.h) and of a team (team_live.h): a bus with processes on it,
// each with its configuration in a file, a logger beside them, and an ear for what they say.
#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/lcm_bus.h"
#include "tools/launch/launcher.h"
#include "tools/mission/run.h"

namespace arpent::tools {

/// For each robot: its processes, which load their worlds, have so long until all have been heard.
inline constexpr std::chrono::seconds kComeUp{30};
/// A mission's own limit ends it; this much later it is ended from outside.
inline constexpr double kPatienceS = 30;

/// What the running processes of a bus say.
class Ear {
 public:
  explicit Ear(const std::string& url);
  /// For so long.
  void listen(std::chrono::milliseconds time);
  /// Orders the mission to start if it still waits: an order can be lost on the way, and a second one is refused.
  void start_mission();
  [[nodiscard]] const std::optional<planning::MissionReport>& report() const { return report_; }
  /// By process.
  [[nodiscard]] const std::map<std::string, ProcessFigures>& figures() const { return figures_; }
  [[nodiscard]] bool ended() const { return report_ && has_ended(*report_); }

 private:
  LcmBus bus_;
  std::map<std::string, ProcessFigures> figures_;
  std::optional<planning::MissionReport> report_;
};

/// A process of a bus, with its configuration.
struct Member {
  std::string name;
  std::string yaml;
};

/// The robot's processes that neither map nor plan; the simulator first.
[[nodiscard]] std::vector<Member> robot_members(const MissionSpec& spec);

struct LiveBusPlace {
  std::string name;              ///< "R1/": before the names of its processes; empty: the only bus
  std::filesystem::path folder;  ///< of its log and configurations
  std::string url;
  int network_fd = -1;  ///< the network namespace that it is in; -1: the caller's
};

class LiveBus {
 public:
  /// Starts the logger. The launcher must outlive it.
  LiveBus(const LiveBusPlace& place, Launcher& launcher, const std::filesystem::path& bin_folder);

  /// `restart`: if it ends by itself.
  void start(const Member& member, bool restart);
  [[nodiscard]] Ear& ear() { return *ear_; }
  [[nodiscard]] const Ear& ear() const { return *ear_; }
  /// The first process that was not heard yet, as the launcher calls it; empty if all were.
  [[nodiscard]] std::string silent() const;
  /// As the launcher calls them, in their order of start, without the logger.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] const std::filesystem::path& raw_log() const { return raw_; }
  /// What the processes said of themselves, and how often one had to be started again. By name of the launcher.
  [[nodiscard]] std::map<std::string, ProcessFigures> figures() const;

 private:
  LiveBusPlace place_;
  Launcher& launcher_;
  std::filesystem::path bin_folder_, raw_;
  std::vector<std::string> names_;
  std::unique_ptr<Ear> ear_;
};

/// Gathers output; throws InputError, naming `log`, when a process has ended that nobody starts again.
void watch(Launcher& launcher, const std::filesystem::path& log);

/// The log of lcm-logger into `result` and into its log: with the CONFIG events before it, and images compressed.
void finish_log(const std::filesystem::path& raw, MissionResult& result, const MissionSpec& spec);

}  // namespace arpent::tools
