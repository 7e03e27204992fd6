// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// pose_process: wheels, gyro, visual odometry and tags in, the fused pose out. Each wheel state gives one POSE, which
// is continuous; each odometry gives one PAIR_POSE, the best estimate at the pair's time. A POSE waits until the gyro
// has reached the wheels' time, or the wheels are `gyro_wait_s` beyond it; a gyro that is silent is not waited for.
//
// What the cameras say of a moment counts once the wheels are `camera_wait_s` beyond it, whenever it came before: so
// both poses depend on the inputs' times alone, and a log of a live robot replays to the same bytes. What comes later
// counts at once, as "late" in health. Where wheels are silent nothing waits for them.
#pragma once

#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "perception/fusion/continuous_pose.h"

namespace arpent {

struct PoseConfig {
  fusion::FusionParams fusion;
  fusion::BlendParams blend;
  double gyro_wait_s = 0.04;
  double camera_wait_s = 0.12;
  int latency_us = 1000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("fusion", self.fusion, "the estimate");
    visitor.group("blend", self.blend, "how corrections come into POSE");
    visitor.field("gyro_wait_s", self.gyro_wait_s, "how far wheels may get ahead of a gyro that is waited for",
                  config::between(0.0, 0.5));
    visitor.field("camera_wait_s", self.camera_wait_s, "how far wheels get ahead of images before these count",
                  config::between(0.0, 0.5));
    visitor.field("latency_us", self.latency_us, "declared time from a message to the pose", config::at_least(0));
  }
};

class PoseProcess {
 public:
  using Config = PoseConfig;
  static constexpr char kName[] = "pose_process";
  static constexpr char kHelp[] = "Fuses wheels, gyro, visual odometry and tags into the pose of the body.";

  /// Throws InputError for parameters that cannot be used.
  PoseProcess(const Config& config, Bus& bus, Clock& clock);
  ~PoseProcess();

  void finish() {}

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
