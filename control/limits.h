// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The one place where a command is held to what the base may do.
#pragma once

#include <algorithm>

#include "common/config/limits.h"
#include "common/twist2.h"

namespace arpent::control {

using Limits = MotionLimits;

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
