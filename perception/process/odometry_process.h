// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// odometry_process: stereo pairs in, exactly one odometry message out for each, in order. A pair that cannot be used
// (black, frozen, wrong size) gives a LOST message, so that whoever waits for this pair's pose is answered.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "perception/odometry/odometry.h"

namespace arpent {

class stereo_images_t;

struct OdometryConfig {
  std::filesystem::path rig;
  odometry::OdometryParams odometry;
  bool use_gyro = true;
  int latency_us = 60000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("rig", self.rig, "rig file: intrinsics and mounting of the stereo camera", config::required_path());
    visitor.group("odometry", self.odometry, "visual odometry");
    visitor.field("use_gyro", self.use_gyro, "IMU, and WHEEL_STATE with it, say where points are looked for");
    visitor.field("latency_us", self.latency_us, "declared time from pair to odometry", config::at_least(0));
  }
};

class OdometryProcess {
 public:
  using Config = OdometryConfig;
  static constexpr char kName[] = "odometry_process";
  static constexpr char kHelp[] = "Estimates the body's motion from stereo pairs.";

  /// Throws InputError for a rig or parameters that cannot be used.
  OdometryProcess(const Config& config, Bus& bus, Clock& clock);
  ~OdometryProcess();

  void finish() {}

 private:
  struct State;
  void on_pair(const stereo_images_t& message);
  std::unique_ptr<State> state_;
};

}  // namespace arpent
