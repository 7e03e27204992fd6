// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The robot file (config/robots): footprint, limits, and which rig it carries.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"

namespace arpent {

struct RobotConfig {
  std::string name = "robot";
  std::filesystem::path rig;
  double semi_axis_long_m = 0.55;
  double semi_axis_short_m = 0.25;
  double max_speed_mps = 0.5;
  double max_turn_rate_radps = 1.0;
  double max_acceleration_mps2 = 0.5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("name", self.name, "name of the robot");
    visitor.field("rig", self.rig, "rig file of its camera", config::required_path());
    visitor.field("semi_axis_long_m", self.semi_axis_long_m, "footprint ellipse, along the heading",
                  config::greater_than(0.0));
    visitor.field("semi_axis_short_m", self.semi_axis_short_m, "footprint ellipse, across it",
                  config::greater_than(0.0));
    visitor.field("max_speed_mps", self.max_speed_mps, "speed limit", config::greater_than(0.0));
    visitor.field("max_turn_rate_radps", self.max_turn_rate_radps, "turn rate limit", config::greater_than(0.0));
    visitor.field("max_acceleration_mps2", self.max_acceleration_mps2, "acceleration limit", config::greater_than(0.0));
  }
};

}  // namespace arpent
