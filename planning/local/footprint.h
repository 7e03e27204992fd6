// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the robot covers of the ground: an ellipse about the body's origin, long axis along the heading (thesis
// Sect. 2.5.3, Table 5.3). For quick checks against a field of distances it is also a row of discs on the long axis.
#pragma once

#include <algorithm>
#include <vector>

#include "common/config/fields.h"
#include "common/pose2.h"

namespace arpent::planning {

struct FootprintParams {
  double semi_axis_long_m = 0.55;
  double semi_axis_short_m = 0.25;

  /// By a margin all around, for planning (planning_margin_m).
  [[nodiscard]] FootprintParams grown(double margin_m) const {
    return {semi_axis_long_m + margin_m, semi_axis_short_m + margin_m};
  }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("semi_axis_long_m", self.semi_axis_long_m, "footprint ellipse, along the heading",
                  config::between(0.05, 3.0));
    visitor.field("semi_axis_short_m", self.semi_axis_short_m, "footprint ellipse, across it",
                  config::between(0.05, 3.0));
  }
};

/// By how much to grow a footprint [m] for plans over a map of such voxels: at least half a voxel, for the surface of
/// coarse voxels cuts corners, and what sticks out of it meets the tail of a robot that turns.
[[nodiscard]] inline double planning_margin_m(double least_m, double voxel_m) {
  return std::max(least_m, 0.5 * voxel_m);
}

/// On the long axis: centre at `along_m` ahead of the origin.
struct FootprintDisc {
  double along_m = 0;
  double radius_m = 0;
};

class Footprint {
 public:
  /// Throws InputError for parameters that break their rules, or if the long axis is the shorter one.
  explicit Footprint(const FootprintParams& params);

  [[nodiscard]] double long_m() const { return params_.semi_axis_long_m; }
  [[nodiscard]] double short_m() const { return params_.semi_axis_short_m; }
  /// They cover the ellipse and stand out of it by less than a tenth of the short axis.
  [[nodiscard]] const std::vector<FootprintDisc>& discs() const { return discs_; }
  /// Whether `p_m` lies in the ellipse of a robot at `pose`, grown by `margin_m` along both axes.
  [[nodiscard]] bool contains(const Pose2& pose, const Eigen::Vector2d& p_m, double margin_m = 0) const;

 private:
  FootprintParams params_;
  std::vector<FootprintDisc> discs_;
};

}  // namespace arpent::planning
