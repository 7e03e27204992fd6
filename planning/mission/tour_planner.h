// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// From clusters of viewpoints to a tour: prices the drives between them (roads.h), orders the clusters by time
// (planning/tour), and lists the viewpoints in the order of the visit.
#pragma once

#include <vector>

#include "common/config/fields.h"
#include "planning/local/ground.h"
#include "planning/local/low_level_planner.h"
#include "planning/mission/roads.h"
#include "planning/tour/max_atsp.h"
#include "planning/tour/timed_tours.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

/// How clusters are put in order.
struct TourParams {
  std::string objective = "time";
  /// Small remains may go away by themselves, seen on the way to others: here the end of the tour counts for less.
  tour::TimedParams time{.completion_weight = 0.3};
  tour::UtilityParams utility;
  tour::SolverParams solver;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("objective", self.objective,
                  "time: surface early and the tour done early; utility: eq. 2.3 of the thesis",
                  config::one_of({"time", "utility"}));
    visitor.group("time", self.time, "objective time");
    visitor.group("utility", self.utility, "objective utility");
    visitor.group("solver", self.solver, "the same");
  }
};

struct PlannedTour {
  Tour tour;  ///< targets' ids are indices into `viewpoints`
  std::vector<Viewpoint> viewpoints;
  double completion_s = 0;
};

/// Drives are priced on cells of twice the ground's size: one search from the robot and one from each cluster. Clusters
/// without a way come last, in their order.
[[nodiscard]] PlannedTour plan_tour(const Ground& ground, const std::vector<Cluster>& clusters, const Pose2& robot,
                                    const TourParams& params, const VisitTimes& times);

/// The tour goes to `viewpoint` before all others.
void put_first(const Viewpoint& viewpoint, PlannedTour& planned);

}  // namespace arpent::planning
