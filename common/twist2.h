// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Motion of a base on the ground.
#pragma once

#include <cmath>

namespace arpent {

/// Speed along the heading and turn rate (counter-clockwise) of the body.
struct Twist2 {
  double speed_mps = 0;
  double turn_rate_radps = 0;

  friend bool operator==(const Twist2&, const Twist2&) = default;
  [[nodiscard]] bool finite() const { return std::isfinite(speed_mps) && std::isfinite(turn_rate_radps); }
};

}  // namespace arpent
