// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a path is made of: arcs and straight pieces driven forwards, and turns on the spot. Their curvature is bounded
// by construction; so are the connections between poses (L. E. Dubins, "On curves of minimal length with a constraint
// on average curvature", 1957).
#pragma once

#include <optional>
#include <vector>

#include "common/pose2.h"

namespace arpent::planning {

/// Either a drive (length_m > 0, constant curvature) or a turn on the spot (length_m == 0).
struct Motion {
  Pose2 start;
  double length_m = 0;
  double curvature_1pm = 0;  ///< positive to the left
  double turn_rad = 0;       ///< of a turn on the spot

  [[nodiscard]] bool is_turn() const { return length_m == 0; }
};

[[nodiscard]] Motion drive(const Pose2& start, double length_m, double curvature_1pm);
/// By the shorter way, as the path tracker turns.
[[nodiscard]] Motion turn_to(const Pose2& start, double heading_rad);

/// The pose at a share of the motion in [0, 1].
[[nodiscard]] Pose2 pose_at(const Motion& motion, double share);
[[nodiscard]] inline Pose2 end_of(const Motion& motion) {
  return pose_at(motion, 1);
}

using Motions = std::vector<Motion>;

/// The ways of turning with `radius_m`, driving straight, and turning again that end in `goal` exactly; up to four, the
/// shortest first. Pieces without length are left out.
[[nodiscard]] std::vector<Motions> connect_with_arcs(const Pose2& start, const Pose2& goal, double radius_m);
/// As above, but straight to the goal's place and turning on the spot there; up to two.
[[nodiscard]] std::vector<Motions> connect_then_turn(const Pose2& start, const Pose2& goal, double radius_m);
/// Turn on the spot, drive straight, turn on the spot.
[[nodiscard]] Motions turn_drive_turn(const Pose2& start, const Pose2& goal);

/// Length of the drives [m]; turns count nothing.
[[nodiscard]] double length_of(const Motions& motions);

}  // namespace arpent::planning
