// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// depth_process: stereo pairs in, disparity and depth out. It rectifies, matches, and publishes what is trusted, at
// most `rate_hz` by the pairs' own time. It has no memory but that rate: each output is a function of one pair.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "perception/stereo/matcher.h"

namespace arpent {

class stereo_images_t;

struct DepthConfig {
  std::filesystem::path rig;
  stereo::MatcherParams matcher;
  double min_range_m = 0.3;
  /// Farther than the map takes surfaces from (tsdf.max_range_m): what is measured there says that nothing is before it.
  double max_range_m = 40.0;
  double rate_hz = 5.0;
  bool publish_disparity = true;
  bool publish_filled = false;
  int latency_us = 80000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("rig", self.rig, "rig file: intrinsics and mounting of the stereo camera", config::required_path());
    visitor.group("matcher", self.matcher, "stereo matching");
    visitor.field("min_range_m", self.min_range_m, "nearer depth is missing", config::greater_than(0.0));
    visitor.field("max_range_m", self.max_range_m, "farther depth is missing", config::between(0.1, 65.0));
    visitor.field("rate_hz", self.rate_hz, "pairs used per second at most, by their own time",
                  config::between(0.01, 1000.0));
    visitor.field("publish_disparity", self.publish_disparity, "publish DISPARITY beside DEPTH");
    visitor.field("publish_filled", self.publish_filled, "publish DISPARITY_FILLED");
    visitor.field("latency_us", self.latency_us, "declared time from pair to depth", config::at_least(0));
  }
};

class DepthProcess {
 public:
  using Config = DepthConfig;
  static constexpr char kName[] = "depth_process";
  static constexpr char kHelp[] = "Computes depth from stereo pairs.";

  /// Throws InputError for a rig or parameters that cannot be used.
  DepthProcess(const Config& config, Bus& bus, Clock& clock);
  ~DepthProcess();

  void finish() {}

 private:
  struct State;
  void on_pair(const stereo_images_t& message);
  std::unique_ptr<State> state_;
};

}  // namespace arpent
