// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// From clusters of viewpoints to a tour: prices the drives between them over the ground, orders the clusters by time
// (planning/tour), and lists the viewpoints in the order of the visit.
#pragma once

#include <vector>

#include "common/config/fields.h"
#include "planning/local/ground.h"
#include "planning/local/low_level_planner.h"
#include "planning/tour/max_atsp.h"
#include "planning/tour/timed_tours.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

/// How clusters are put in order.
struct TourParams {
  std::string objective = "time";
  tour::TimedParams time;
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

struct VisitTimes {
  double speed_mps = 0.5;
  double turn_rate_radps = 1.0;
  double visit_s = 0;   ///< at each viewpoint, at least
  double looks_hz = 5;  ///< depth images per second
};

/// The same ground in cells of twice the size, each as bad as the worst of its four: for prices.
[[nodiscard]] Ground halve(const Ground& ground);

/// Drives are priced on cells of twice the ground's size: one search from the robot and one from each cluster. Clusters
/// without a way come last, in their order.
[[nodiscard]] PlannedTour plan_tour(const Ground& ground, const std::vector<Cluster>& clusters, const Pose2& robot,
                                    const TourParams& params, const VisitTimes& times);

}  // namespace arpent::planning
