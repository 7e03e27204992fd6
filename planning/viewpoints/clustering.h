// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Viewpoints that are visited together (thesis Sect. 2.4.3), and what a visit is worth (eq. 2.1).
#pragma once

#include <span>
#include <vector>

#include "planning/viewpoints/free_space.h"
#include "planning/viewpoints/sight.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

/// The viewpoints of each cluster, by index, ascending; clusters ordered by their first viewpoint. Each viewpoint is in
/// exactly one.
using Partition = std::vector<std::vector<std::size_t>>;

/// As the thesis has it: a viewpoint joins a cluster if one of its members is nearer than d_v (so clusters chain). For
/// one that stays alone, d_v grows up to d_v_max until a neighbour is found, the nearest. Distances are Euclidean.
[[nodiscard]] Partition cluster_by_single_linkage(std::span<const Viewpoint> viewpoints, const ViewpointParams& params);

/// The same with the length of the drive as distance, and no two viewpoints of a cluster farther apart than
/// max_diameter_m: the nearest pairs join first, as long as all members of both stay that near.
[[nodiscard]] Partition cluster_by_drive(std::span<const Viewpoint> viewpoints, const ViewpointParams& params,
                                         const FreeSpace& free_space);

/// Clusters with ids 0, 1, …, their elements and their gain: the share of all elements that are seen from their
/// viewpoints (preset thesis), or that the looks planned there complete (default).
[[nodiscard]] std::vector<Cluster> make_clusters(std::span<const Viewpoint> viewpoints, const Partition& partition,
                                                 const Sight& sight, const ViewpointParams& params);

}  // namespace arpent::planning
