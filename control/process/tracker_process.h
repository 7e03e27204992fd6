// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// tracker_process: a path and the fused pose in, wheel commands out. It steps when a POSE comes that is a period after
// the last step, so that its commands are a function of its messages. A timer only watches: if no pose comes for
// `max_pose_age_s` by the local clock, it brakes.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "control/path_tracker.h"

namespace arpent {

struct TrackerConfig {
  std::filesystem::path robot;
  /// Every other POSE; a pose is stale before the dead man's switch of the base acts (200 ms). The limits come from the
  /// robot file.
  control::TrackerParams tracker{.limits = {}, .period_s = 0.04, .max_pose_age_s = 0.12};
  bool dry_run = false;
  int latency_us = 1000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("robot", self.robot, "robot file: its limits", config::required_path());
    control::TrackerParams::describe_tracking(self.tracker, visitor);
    visitor.field("dry_run", self.dry_run, "publish status only, no commands");
    visitor.field("latency_us", self.latency_us, "declared time from pose to command", config::at_least(0));
  }
};

class TrackerProcess {
 public:
  using Config = TrackerConfig;
  static constexpr char kName[] = "tracker_process";
  static constexpr char kHelp[] = "Follows paths: publishes wheel commands.";

  /// Throws InputError for a robot file or parameters that cannot be used.
  TrackerProcess(const Config& config, Bus& bus, Clock& clock);
  ~TrackerProcess();

  /// Tells the base to stand.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
