// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the base may do, and the one place where a command is held to it.
#pragma once

#include <algorithm>

#include "common/config/fields.h"
#include "common/twist2.h"

namespace arpent::control {

struct Limits {
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

/// `wanted`, held to the limits and to what can change from `last` within `period_s`.
[[nodiscard]] inline Twist2 hold_to_limits(const Twist2& wanted, const Twist2& last, const Limits& limits,
                                           double period_s) {
  const auto hold = [&](double value, double before, double most, double rate) {
    return std::clamp(std::clamp(value, before - rate * period_s, before + rate * period_s), -most, most);
  };
  return {hold(wanted.speed_mps, last.speed_mps, limits.max_speed_mps, limits.max_acceleration_mps2),
          hold(wanted.turn_rate_radps, last.turn_rate_radps, limits.max_turn_rate_radps,
               limits.max_turn_acceleration_radps2)};
}

}  // namespace arpent::control
