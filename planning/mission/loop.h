// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A path of test drives: from where the robot stands onto a rectangle with rounded corners, and round it so many times.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/config/fields.h"
#include "common/pose2.h"

namespace arpent::planning {

struct LoopParams {
  std::vector<double> centre_m{0, 0};
  std::vector<double> size_m{4, 3};
  double corner_radius_m = 0.75;
  std::vector<double> entry_m{0, -1.5};
  int laps = 2;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("centre_m", self.centre_m, "centre of the rectangle, world frame", config::finite_numbers(2));
    visitor.field("size_m", self.size_m, "its extent in x and y", config::finite_numbers(2));
    visitor.field("corner_radius_m", self.corner_radius_m, "radius of its corners", config::greater_than(0.0));
    visitor.field("entry_m", self.entry_m, "where it is joined and left: a point of its lower side",
                  config::finite_numbers(2));
    visitor.field("laps", self.laps, "how often it is driven round, counter-clockwise", config::between(1, 1000));
  }
};

/// Points every 5 cm at most. Throws InputError if the corners do not fit the sides or the entry is not on the straight
/// part of the lower side.
[[nodiscard]] std::vector<Eigen::Vector2d> make_loop(const Pose2& start, const LoopParams& params);

}  // namespace arpent::planning
