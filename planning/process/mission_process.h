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
#include "planning/mission/loop.h"

namespace arpent {

struct MissionConfig {
  std::string kind = "loop";
  std::string map_frame = "world";
  double max_time_s = 1800;
  planning::LoopParams loop;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("kind", self.kind, "what to do", config::one_of({"loop"}));
    visitor.field("map_frame", self.map_frame, "frame to work in: world needs an alignment with the tag cube first",
                  config::one_of({"world", "odom"}));
    visitor.field("max_time_s", self.max_time_s, "the mission is aborted after so long", config::greater_than(0.0));
    visitor.group("loop", self.loop, "the test path of kind loop");
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

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
