// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Teammates on the ground: their footprints, which no map holds, stamped on what the map says. And how far footprints
// are from each other.
#pragma once

#include <span>

#include "planning/local/ground.h"

namespace arpent::planning {

/// The grid's ground with each body's ellipse, grown by `gap_m`, occupied. Cells that the robot at `own` covers itself
/// are left as they are, so that it can drive off.
[[nodiscard]] Ground ground_with_bodies(const GroundGrid& grid, const Footprint& footprint, const DriveCosts& costs,
                                        std::span<const Pose2> bodies, const Footprint& of_bodies, double gap_m,
                                        const Pose2& own);

/// Distance between the ellipses of two robots at these poses, too small by no more than a fifth of the short axis;
/// negative if they overlap.
[[nodiscard]] double gap_m(const Footprint& footprint, const Pose2& a, const Pose2& b);

}  // namespace arpent::planning
