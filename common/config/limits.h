// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How fast a robot may move and change its motion. The one place of these defaults: the robot file, the path tracker
// and the base driver's gate all hold this struct.
#pragma once

#include "common/config/fields.h"

namespace arpent {

struct MotionLimits {
  double max_speed_mps = 0.5;
  double max_turn_rate_radps = 1.0;
  double max_acceleration_mps2 = 0.5;
  double max_turn_acceleration_radps2 = 3.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("max_speed_mps", self.max_speed_mps, "speed limit", config::between(0.01, 5.0));
    visitor.field("max_turn_rate_radps", self.max_turn_rate_radps, "turn rate limit", config::between(0.01, 10.0));
    visitor.field("max_acceleration_mps2", self.max_acceleration_mps2, "acceleration limit",
                  config::between(0.01, 10.0));
    visitor.field("max_turn_acceleration_radps2", self.max_turn_acceleration_radps2, "limit of the turn rate's change",
                  config::between(0.01, 50.0));
  }
};

}  // namespace arpent
