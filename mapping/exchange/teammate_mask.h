// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Teammates in view (thesis Sect. 5.2.2): the part of a depth image where a teammate must be is made neutral, neither
// surface nor free space, before the image gets into a map. From the teammates' poses alone; nothing is recognised.
#pragma once

#include <span>

#include "common/config/fields.h"
#include "common/pose2.h"
#include "perception/stereo/depth_map.h"

namespace arpent::mapping {

struct TeammateMaskParams {
  double half_length_m = 0.35;
  double half_width_m = 0.27;
  double height_m = 0.50;
  double margin_m = 0.08;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("half_length_m", self.half_length_m, "half of a teammate's box, along its heading",
                  config::between(0.01, 5.0));
    visitor.field("half_width_m", self.half_width_m, "the same across", config::between(0.01, 5.0));
    visitor.field("height_m", self.height_m, "its height above the floor", config::between(0.01, 5.0));
    visitor.field("margin_m", self.margin_m,
                  "by which the box is grown to all sides: errors of both poses and of depth",
                  config::between(0.0, 1.0));
  }
};

/// Where a teammate stands. `uncertainty_m` grows its box further: speed times the age of the pose.
struct SeenTeammate {
  Pose2 body;
  double uncertainty_m = 0;
};

/// Sets depth and deviation to missing in the convex outline of each teammate's box that lies before the camera. The
/// images of `depth` are changed in place. Returns how many measured pixels that were.
int mask_teammates(stereo::DepthMap& depth, const Pose& T_map_cam, std::span<const SeenTeammate> teammates,
                   const TeammateMaskParams& params);

}  // namespace arpent::mapping
