// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/tour_planner.h"

#include <algorithm>
#include <cmath>

#include "planning/tour/cluster_graph.h"

namespace arpent::planning {
namespace {

/// Clusters in the order of the visit and how long that takes [s].
struct Ordered {
  std::vector<int> clusters;
  double completion_s = 0;
};

Ordered order_by_time(const tour::ClusterGraph& graph, const tour::Arcs& durations_s, const tour::TimedParams& params) {
  const tour::TimedTours tours = tour::timed_tours(durations_s, graph.gains(), params);
  Ordered ordered{tours.order.front(), tours.completion_s};
  ordered.clusters.insert(ordered.clusters.end(), tours.unreachable.begin(), tours.unreachable.end());
  return ordered;
}

Ordered order_by_utility(const tour::ClusterGraph& graph, const tour::Arcs& durations_s, const TourParams& params) {
  const tour::Arcs utilities = graph.utilities(params.utility.lambda_tc_1pm, params.utility.lambda_ic_1pm);
  std::vector<double> from_start;
  for (int v = 0; v < graph.size(); ++v) from_start.push_back(utilities.from_start(0, v));
  Ordered ordered{tour::max_atsp(from_start, utilities.among, params.solver).order};
  for (std::size_t i = 0; i < ordered.clusters.size(); ++i) {
    const int v = ordered.clusters[i];
    const double s = i == 0 ? durations_s.from_start(0, v) : durations_s.among(ordered.clusters[i - 1], v);
    if (std::isfinite(s)) ordered.completion_s += s;
  }
  return ordered;
}

}  // namespace

PlannedTour plan_tour(const Ground& ground, const std::vector<Cluster>& clusters, const Pose2& robot,
                      const TourParams& params, const VisitTimes& times) {
  const RobotPlace place{robot, 0};
  const Roads roads(ground, clusters, {&place, 1});
  // No drive is shorter than the straight line, whatever its cells say.
  const auto drive_m = [&](int from, int to) { return std::max(roads.straight_m(from, to), roads(from, to)); };
  const tour::ClusterGraph graph(roads.nodes(), roads.starts(), drive_m);
  const tour::Arcs durations_s = visit_durations_s(graph, clusters, {&place, 1}, times);
  const auto [order, completion_s] = params.objective == "time" ? order_by_time(graph, durations_s, params.time)
                                                                : order_by_utility(graph, durations_s, params);
  PlannedTour planned;
  planned.viewpoints = roads.viewpoints();
  for (const int viewpoint : graph.viewpoints(0, order)) {
    planned.tour.targets.push_back({viewpoint, planned.viewpoints[static_cast<std::size_t>(viewpoint)].pose});
  }
  // What the first cluster is for decides when to plan anew; the others are where to go if it cannot be reached.
  if (!order.empty()) planned.tour.elements = clusters[static_cast<std::size_t>(order.front())].elements;
  planned.completion_s = completion_s;
  return planned;
}

void put_first(const Viewpoint& viewpoint, PlannedTour& planned) {
  const TourTarget target{static_cast<std::int64_t>(planned.viewpoints.size()), viewpoint.pose};
  planned.viewpoints.push_back(viewpoint);
  planned.tour.targets.insert(planned.tour.targets.begin(), target);
}

}  // namespace arpent::planning
