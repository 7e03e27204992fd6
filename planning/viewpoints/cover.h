// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Few viewpoints that complete much: poses that many elements ask for, and of these a greedy set cover. Preset
// `default`; the thesis takes one viewpoint per element and merges neighbours (generation.h).
#pragma once

#include <vector>

#include "planning/viewpoints/free_space.h"
#include "planning/viewpoints/sight.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

/// Beside delta_pose, a stand-off this much farther, from which more elements are in view.
constexpr double kFartherM = 0.8;

struct Cover {
  /// Each element is listed by the viewpoints that complete its unknown voxels. In the order in which they were chosen:
  /// the first one completes most.
  std::vector<Viewpoint> viewpoints;
  /// Elements that no pose tried completes, by index, ascending; those given up (Sight) among them.
  std::vector<std::uint32_t> left;
  /// What is left only waits: it has to be asked about again once these viewpoints have been visited.
  bool postponed = false;
};

/// A flag for each element: not gone for.
using Skipped = std::vector<std::uint8_t>;

/// What a viewpoint may count on.
struct Effort {
  int looks = 1;
  double unknown_reach_m = 0;   ///< see Sight::look_at_unknowns()
  std::size_t least_worth = 1;  ///< unknown voxels that a viewpoint has to complete
};

/// Poses on a lattice, around each element within 60 degrees of the direction from which it wants to be seen (all round
/// for steep ones), free and reachable from `robot`. A pose completes an unknown voxel if `looks` from there, of weight
/// 1/z^2 each, lift it to W_th. One viewpoint after the other is taken that completes most of what is left (a (1 - 1/e)
/// approximation for any number of them: Nemhauser, Wolsey and Fisher, "An analysis of approximations for maximizing
/// submodular set functions", 1978). In rounds: first the poses that most elements ask for, and only what is worth a
/// stop; what is left may ask for more poses, all round, and for `max_looks`. With min_viewpoint_m2 the first round
/// that finds viewpoints is the last.
/// Elements with a flag in `skipped` are neither covered nor left.
[[nodiscard]] Cover cover_elements(const Sight& sight, const FreeSpace& free_space, const Pose2& robot,
                                   const ViewpointParams& params, const Skipped& skipped = {});

/// One more round, with these poses: completes `left` as far as they can.
void extend_cover(Cover& cover, const Sight& sight, const std::vector<Pose2>& poses, const Effort& effort);

}  // namespace arpent::planning
