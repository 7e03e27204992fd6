// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// team_link_process: a station's end of the radio, one per bus (each robot's, and the centre's). What its own processes
// send to the team goes to the other stations' processes, and comes out on their buses under the TEAM_ names; it looks
// into no message. In lockstep radio_process does the same. Live only: it publishes from a thread of its own.
#pragma once

#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "link/params.h"

namespace arpent {

struct TeamLinkConfig {
  std::string role = "robot";
  double beat_hz = 20;
  link::StationParams station;
  link::LinkParams link;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    link::StationParams::describe(self.station, visitor);
    visitor.field("role", self.role, "robot: sends patches, states, reports, hears tours; centre: sends tours",
                  config::one_of({"robot", "centre"}));
    visitor.field("beat_hz", self.beat_hz, "signs of life, and the emergency stop as a state",
                  config::between(20.0, 50.0));
    visitor.group("link", self.link, "the network");
  }
};

class TeamLinkProcess {
 public:
  using Config = TeamLinkConfig;
  static constexpr char kName[] = "team_link_process";
  static constexpr char kHelp[] = "Carries what a team tells each other between robots and ground station.";

  /// Throws InputError if keys are missing.
  TeamLinkProcess(const Config& config, Bus& bus, Clock& clock);
  ~TeamLinkProcess();

  /// Leaves the network; after it nothing is published.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
