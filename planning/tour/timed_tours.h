// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The default planner of tours, for one robot or a team: surface early, and everybody home early. It minimises the mean
// time at which surface is completed (each cluster counts by its gain) plus a share of the time at which the last robot
// finishes. The second part is what keeps leftovers from being driven past, and what balances a team (min-max).
// Why not eq. 2.3 by default: bench `planning`, rows `tour.*`.
#pragma once

#include <cstdint>
#include <vector>

#include "common/config/fields.h"
#include "planning/tour/cluster_graph.h"

namespace arpent::tour {

struct TimedParams {
  double completion_weight = 1.0;
  double steps = 1e6;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("completion_weight", self.completion_weight,
                  "seconds of mean arrival that a second of the last robot's finish is worth", config::at_least(0.0));
    visitor.field("steps", self.steps, "places for a cluster that the search looks at (1e6 take about 20 ms)",
                  config::between(0.0, 1e12));
  }
};

struct TimedTours {
  std::vector<std::vector<int>> order;  ///< clusters by visit, one list per robot, empty if it is not needed
  double mean_arrival_s = 0;            ///< gain-weighted, over the clusters in `order`
  double completion_s = 0;              ///< of the robot that finishes last
  double objective_s = 0;               ///< mean arrival + completion_weight * completion
  std::vector<int> unreachable;         ///< clusters that no robot has a way to
};

/// `legs_s` as from ClusterGraph::durations_s, infinite where there is no way; `gain` one per cluster, not negative
/// (if all are zero, arrivals do not count). One robot and at most 12 clusters: exact. Otherwise ruin and recreate
/// (Christiaens and Vanden Berghe 2020) from `warm` tours (empty, or one per robot, with known clusters only); never
/// worse than greedy insertion of the rest into them, and more steps are never worse. Throws InputError for times or
/// gains that are negative or not numbers.
[[nodiscard]] TimedTours timed_tours(const Arcs& legs_s, const std::vector<double>& gain, const TimedParams& params,
                                     const std::vector<std::vector<int>>& warm = {});

/// What `order` is worth under the same objective. Every leg must have a way.
[[nodiscard]] TimedTours evaluate_timed(const Arcs& legs_s, const std::vector<double>& gain, const TimedParams& params,
                                        std::vector<std::vector<int>> order);

}  // namespace arpent::tour
