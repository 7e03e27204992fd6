// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// centre_process: the team's one plan. Takes the robots' patches, states and reports as they come over the radio, keeps
// the fused map, and sends tours (planning/team/centre.h). Runs on a ground station or on a robot.
// If it ends and is started again it reads its journal; what it missed meanwhile the robots send again.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "planning/team/centre.h"

namespace arpent {

struct CentreConfig {
  std::filesystem::path rig;
  planning::CentreParams centre;
  std::filesystem::path map_file;
  std::filesystem::path journal_file;
  int latency_us = 20000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("rig", self.rig, "rig file of the robots: what their cameras see", config::required_path());
    visitor.group("centre", self.centre, "the plan");
    visitor.field("map_file", self.map_file, "where the fused map is saved at the end; empty: nowhere");
    visitor.field("journal_file", self.journal_file,
                  "what the centre took and sent; one for each mission. A centre that finds it goes on from there; "
                  "empty: none");
    visitor.field("latency_us", self.latency_us, "declared time to fuse a patch", config::at_least(0));
  }
};

class CentreProcess {
 public:
  using Config = CentreConfig;
  static constexpr char kName[] = "centre_process";
  static constexpr char kHelp[] = "Fuses a team's map and plans its tours.";

  /// Throws InputError for a rig, parameters or a journal that cannot be used.
  CentreProcess(const Config& config, Bus& bus, Clock& clock);
  ~CentreProcess();

  /// Saves the map if that was asked for. Throws InputError if the disk refuses.
  void finish();
  [[nodiscard]] const planning::Centre& centre() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
