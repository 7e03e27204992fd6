// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// mission_process: what the robot is there for. It waits for the start, arms the base, waits until the robot knows
// where it is in the world, gives the path tracker its paths, and says once a second how far it is. A `loop` drives a
// test path; `explore` is the main job (explorer.h).
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "planning/local/stop_guard.h"
#include "planning/mission/explorer.h"
#include "planning/mission/loop.h"
#include "planning/process/team_member.h"

namespace arpent {

struct MissionConfig {
  std::string kind = "loop";
  std::string map_frame = "world";
  double max_time_s = 1800;
  std::filesystem::path rig;
  std::filesystem::path certificate_file;
  planning::LoopParams loop;
  planning::ExplorerParams explore;
  planning::StopGuardParams stop_guard;
  TeamMemberParams team;
  int latency_us = 60000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("kind", self.kind, "what to do", config::one_of({"loop", "explore"}));
    visitor.field("map_frame", self.map_frame, "frame to work in: world needs an alignment with the tag cube first",
                  config::one_of({"world", "odom"}));
    visitor.field("max_time_s", self.max_time_s, "the mission is aborted after so long", config::greater_than(0.0));
    visitor.field("rig", self.rig, "rig file: what the camera sees (kind explore)");
    visitor.field("certificate_file", self.certificate_file,
                  "written at the end: what stayed incomplete and why (kind explore); empty: none");
    visitor.group("loop", self.loop, "the test path of kind loop");
    visitor.group("explore", self.explore, "the exploration of kind explore");
    visitor.group("stop_guard", self.stop_guard, "stops for what stands in the way (kind explore)");
    visitor.group("team", self.team, "the robot as one of a team (kind explore)");
    visitor.field("latency_us", self.latency_us, "declared time from depth to path", config::at_least(0));
  }
};

class MissionProcess {
 public:
  using Config = MissionConfig;
  static constexpr char kName[] = "mission_process";
  static constexpr char kHelp[] = "Leads a mission from its start to its end.";

  /// Throws InputError for a mission that cannot be.
  MissionProcess(const Config& config, Bus& bus, Clock& clock);
  ~MissionProcess();

  void finish();
  /// What kind explore knows; nullptr for other kinds.
  [[nodiscard]] const planning::Explorer* explorer() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
