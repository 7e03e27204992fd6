// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// patch_process: a robot's depth images into map patches for its team. Each image is joined with the pose of its pair;
// teammates in view are masked out first. What the centre has not had is sent again: the radio loses little, but a
// centre that ends and starts again has missed what came in between.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "mapping/exchange/patch_builder.h"
#include "mapping/exchange/teammate_mask.h"

namespace arpent {

struct PatchConfig {
  std::filesystem::path rig;
  std::string source = "R1";
  std::string map_frame = "world";
  mapping::TsdfParams tsdf;
  mapping::PatchParams patch;
  mapping::TeammateMaskParams mask;
  double send_again_s = 10;
  int latency_us = 60000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("rig", self.rig, "rig file: intrinsics and mounting of the stereo camera", config::required_path());
    visitor.field("source", self.source, "the robot's name in its team", config::required_text());
    visitor.field("map_frame", self.map_frame, "depth is passed over until the pose is of this frame",
                  config::one_of({"world", "odom"}));
    visitor.group("tsdf", self.tsdf, "the lattice, the same for all of the team");
    visitor.group("patch", self.patch, "what makes a patch");
    visitor.group("mask", self.mask, "what teammates cover");
    visitor.field("send_again_s", self.send_again_s, "a patch that the centre has not had after so long is sent again",
                  config::greater_than(0.0));
    visitor.field("latency_us", self.latency_us, "declared time from depth to patch", config::at_least(0));
  }
};

class PatchProcess {
 public:
  using Config = PatchConfig;
  static constexpr char kName[] = "patch_process";
  static constexpr char kHelp[] = "Makes map patches of a robot's depth images for its team.";

  /// Throws InputError for a rig or parameters that cannot be used.
  PatchProcess(const Config& config, Bus& bus, Clock& clock);
  ~PatchProcess();

  void finish() {}

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
