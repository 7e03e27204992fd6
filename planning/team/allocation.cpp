// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/allocation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planning/tour/cluster_graph.h"

namespace arpent::planning {
namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();
/// Nearer than this a viewpoint is turned to, not driven to.
constexpr double kNearM = 0.1;

using Orders = std::vector<std::vector<int>>;

Orders by_time(const tour::ClusterGraph& graph, const std::vector<Cluster>& clusters,
               const std::vector<RobotPlace>& robots, const AllocationParams& params, const VisitTimes& times) {
  return tour::timed_tours(visit_durations_s(graph, clusters, robots, times), graph.gains(), params.time).order;
}

Orders by_tsga(const tour::ClusterGraph& graph, const std::vector<Cluster>& clusters,
               const std::vector<RobotPlace>& robots, const AllocationParams& params) {
  tour::Matrix distance_m(graph.robots(), graph.size());
  for (int r = 0; r < graph.robots(); ++r) {
    for (int v = 0; v < graph.size(); ++v) {
      distance_m(r, v) = kNoWay;
      for (const Viewpoint& viewpoint : clusters[static_cast<std::size_t>(v)].viewpoints) {
        const Eigen::Vector2d way = viewpoint.pose.position_m() - robots[static_cast<std::size_t>(r)].from.position_m();
        distance_m(r, v) = std::min(distance_m(r, v), way.norm());
      }
    }
  }
  const tour::Arcs utility = graph.utilities(params.utility.lambda_tc_1pm, params.utility.lambda_ic_1pm);
  Orders orders;
  for (tour::OpenTour& tour : tour::tsga(utility, distance_m, params.tsga)) orders.push_back(std::move(tour.order));
  return orders;
}

Orders by_nearest(const tour::ClusterGraph& graph, const AllocationParams& params) {
  const tour::Arcs utility = graph.utilities(params.utility.lambda_tc_1pm, params.utility.lambda_ic_1pm);
  Orders orders;
  for (const int pick : tour::nearest_neighbour_picks(utility.from_start, false)) {
    orders.push_back(pick < 0 ? std::vector<int>{} : std::vector<int>{pick});
  }
  return orders;
}

/// Clusters that nobody has a way to are tried by whoever is nearest as the crow flies, after everything else.
void add_unreached(Orders& orders, const std::vector<Cluster>& clusters, const std::vector<RobotPlace>& robots) {
  std::vector<char> given(clusters.size());
  for (const auto& order : orders) {
    for (const int v : order) given[static_cast<std::size_t>(v)] = 1;
  }
  for (std::size_t v = 0; v < clusters.size(); ++v) {
    if (given[v] != 0) continue;
    const auto off_m = [&](const RobotPlace& r) { return (r.from.position_m() - clusters[v].centre_m).norm(); };
    const auto nearest = std::min_element(
        robots.begin(), robots.end(), [&](const RobotPlace& a, const RobotPlace& b) { return off_m(a) < off_m(b); });
    orders[static_cast<std::size_t>(nearest - robots.begin())].push_back(static_cast<int>(v));
  }
}

/// Elements completed per second of the way to a viewpoint, the turns and the stay.
double rate_of(const Viewpoint& viewpoint, double drive_m, const Pose2& robot, const VisitTimes& times) {
  const Eigen::Vector2d way = viewpoint.pose.position_m() - robot.position_m();
  const double bearing = way.norm() > kNearM ? std::atan2(way.y(), way.x()) : robot.yaw_rad;
  const double turns_rad =
      std::abs(wrap_angle(bearing - robot.yaw_rad)) + std::abs(wrap_angle(viewpoint.pose.yaw_rad - bearing));
  const double time_s = drive_m / times.speed_mps + turns_rad / times.turn_rate_radps +
                        std::max(times.visit_s, viewpoint.looks / times.looks_hz);
  return static_cast<double>(viewpoint.elements.size()) / time_s;
}

/// Of what a robot was given, what completes most per second comes first. So for a team alone: a robot by itself drives
/// its tour in order (tour_planner.cpp).
void put_best_first(std::vector<int>& tour, const Roads& roads, int start, const Pose2& robot,
                    const VisitTimes& times) {
  if (tour.empty()) return;
  const auto rate = [&](int v) {
    return rate_of(roads.viewpoints()[static_cast<std::size_t>(v)], roads(start, v), robot, times);
  };
  const auto best = std::max_element(tour.begin(), tour.end(), [&](int a, int b) { return rate(a) < rate(b); });
  std::rotate(tour.begin(), best, best + 1);
}

}  // namespace

std::vector<std::vector<Viewpoint>> allocate(const Ground& ground, const std::vector<Cluster>& clusters,
                                             const std::vector<RobotPlace>& robots, const AllocationParams& params,
                                             const VisitTimes& times) {
  std::vector<std::vector<Viewpoint>> given(robots.size());
  if (clusters.empty() || robots.empty()) return given;
  const Roads roads(ground, clusters, robots);
  const tour::ClusterGraph graph(roads.nodes(), roads.starts(), roads);
  Orders orders = params.objective == "tsga"  ? by_tsga(graph, clusters, robots, params)
                  : params.objective == "nnb" ? by_nearest(graph, params)
                                              : by_time(graph, clusters, robots, params, times);
  if (params.objective != "nnb") add_unreached(orders, clusters, robots);
  for (std::size_t r = 0; r < robots.size(); ++r) {
    std::vector<int> tour = graph.viewpoints(static_cast<int>(r), orders[r]);
    if (params.objective == "time") put_best_first(tour, roads, roads.starts()[r], robots[r].from, times);
    for (const int v : tour) given[r].push_back(roads.viewpoints()[static_cast<std::size_t>(v)]);
  }
  return given;
}

}  // namespace arpent::planning
