// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A whole exploration without processes: a robot that follows its legs exactly, at constant speeds, through a simulated
// world and senses exact depth on the way. What viewpoints, tours and legs make of a world, apart from everything that
// moves and measures badly; and how long each new plan takes.
#pragma once

#include <vector>

#include "planning/viewpoints/viewpoint.h"
#include "sim/world/world.h"

namespace arpent::bench {

struct LoopParams {
  double voxel_m = 0.2;
  planning::ViewpointParams viewpoints = {};
  double longest_s = 3600;  ///< of simulated time, then it ends unfinished
  bool progress = false;    ///< one line per plan
};

struct LoopResult {
  bool finished = false;  ///< nothing was left that a viewpoint could complete
  double time_s = 0;      ///< driving, turning and looking
  double path_m = 0;
  int visits = 0;     ///< viewpoints reached
  int back_offs = 0;  ///< no leg led on from where it stood
  std::size_t elements_left = 0;
  std::size_t completable_left = 0;  ///< of these, judged completable from poses that the robot can reach
  std::size_t known_voxels = 0;      ///< of the map
  std::vector<double> total_ms;      ///< per plan, CPU: ground, viewpoints, tour, first leg
  std::vector<double> targets_ms;    ///< per plan, CPU: viewpoints and clusters alone
  std::vector<double> note_look_ms;  ///< per depth image
};

/// From the world's first start. Deterministic but for the times.
[[nodiscard]] LoopResult explore(const sim::World& world, const LoopParams& params);

}  // namespace arpent::bench
