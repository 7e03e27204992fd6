// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How near a team's robots truly came to each other, from their true ways.
#pragma once

#include <vector>

#include "common/config/robot.h"
#include "tools/evaluation/trajectory.h"

namespace arpent::tools {

struct TeamEncounters {
  int overlaps = 0;          ///< how often the footprints of two robots came to overlap
  double least_gap_m = 1e9;  ///< between footprints, ever
};

/// `truths`: body in world, one trajectory per robot, stamps ascending. Each two robots are compared at the stamps of
/// the former while the latter's way lasts; between its stamps the latter moved evenly.
[[nodiscard]] TeamEncounters encounters_of(const RobotConfig& robot, const std::vector<evaluation::Trajectory>& truths);

}  // namespace arpent::tools
