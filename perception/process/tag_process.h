// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// tag_process: stereo pairs and their odometry in; what the pairs say about the tag cube out, and where odom lies in
// the world once enough pairs agree. Until the alignment is final, pairs are searched at `rate_hz`; afterwards at
// `aligned_rate_hz`, so that others can correct drift whenever the robot comes by the cube.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "perception/tags/alignment.h"
#include "perception/tags/cube.h"
#include "perception/tags/cube_pose.h"
#include "perception/tags/detector.h"

namespace arpent {

class odometry_t;
class stereo_images_t;

struct TagConfig {
  std::filesystem::path rig;
  tags::TagCubeConfig cube;
  tags::DetectorParams detector;
  tags::GroundParams ground;
  tags::AlignmentParams alignment;
  double rate_hz = 5.0;
  double aligned_rate_hz = 1.0;
  int latency_us = 20000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("rig", self.rig, "rig file: intrinsics and mounting of the stereo camera", config::required_path());
    visitor.group("cube", self.cube, "the tag cube that defines the world");
    visitor.group("detector", self.detector, "search for tags");
    visitor.group("ground", self.ground, "how flat the ground is");
    visitor.group("alignment", self.alignment, "odom in the world");
    visitor.field("rate_hz", self.rate_hz, "most pairs per second until the alignment is final, by the pairs' own time",
                  config::between(0.1, 100.0));
    visitor.field("aligned_rate_hz", self.aligned_rate_hz, "the same afterwards", config::between(0.01, 100.0));
    visitor.field("latency_us", self.latency_us, "declared time from pair to observation", config::at_least(0));
  }
};

class TagProcess {
 public:
  using Config = TagConfig;
  static constexpr char kName[] = "tag_process";
  static constexpr char kHelp[] = "Finds the tag cube and the place of the odometry frame in the world.";

  /// Throws InputError for a rig, a cube or parameters that cannot be used.
  TagProcess(const Config& config, Bus& bus, Clock& clock);
  ~TagProcess();

  void finish() {}

 private:
  struct State;
  void on_pair(const stereo_images_t& message);
  void on_odometry(const odometry_t& message);
  void align_ready();
  std::unique_ptr<State> state_;
};

}  // namespace arpent
