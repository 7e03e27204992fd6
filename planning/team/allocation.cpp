// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/allocation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "planning/local/sweep.h"
#include "planning/tour/cluster_graph.h"

namespace arpent::planning {
namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();
/// Drives within a cluster are short: the straight line, and a little more for what is in between.
constexpr double kDetour = 1.15;
/// Nearer than this a viewpoint is turned to, not driven to.
constexpr double kNearM = 0.1;

/// Viewpoints by number, cluster after cluster, then the robots; and the lengths of drives between them.
class Roads {
 public:
  Roads(const Ground& ground, const std::vector<Cluster>& clusters, const std::vector<RobotPlace>& robots) {
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      tour::Cluster node{{}, clusters[c].gain};
      for (const Viewpoint& viewpoint : clusters[c].viewpoints) {
        node.viewpoints.push_back(static_cast<int>(viewpoints_.size()));
        viewpoints_.push_back(viewpoint);
        source_.push_back(robots.size() + c);
      }
      nodes_.push_back(std::move(node));
    }
    const Ground coarse = halve(ground);
    for (std::size_t r = 0; r < robots.size(); ++r) {
      starts_.push_back(static_cast<int>(viewpoints_.size() + r));
      search(coarse, robots[r].from.position_m());
    }
    for (const Cluster& cluster : clusters) search(coarse, middle_of(cluster));
  }

  /// The nearest way from the robot or from the middle of the cluster, and the rest by the triangle's inequality.
  [[nodiscard]] double operator()(int from, int to) const {
    const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
    if (a >= viewpoints_.size()) return searches_[a - viewpoints_.size()].length_m[b];
    const Eigen::Vector2d p = viewpoints_[a].pose.position_m(), q = viewpoints_[b].pose.position_m();
    if (source_[a] == source_[b]) return kDetour * (p - q).norm();
    const Search& search = searches_[source_[a]];
    return std::max((p - q).norm(), search.length_m[b] - (p - search.p_m).norm());
  }

  [[nodiscard]] const std::vector<Viewpoint>& viewpoints() const { return viewpoints_; }
  [[nodiscard]] const std::vector<tour::Cluster>& nodes() const { return nodes_; }
  [[nodiscard]] const std::vector<int>& starts() const { return starts_; }

 private:
  struct Search {
    Eigen::Vector2d p_m;
    std::vector<double> length_m;  ///< to each viewpoint
  };

  static Eigen::Vector2d middle_of(const Cluster& cluster) {
    const auto off_m = [&](const Viewpoint& v) { return (v.pose.position_m() - cluster.centre_m).norm(); };
    return std::min_element(cluster.viewpoints.begin(), cluster.viewpoints.end(),
                            [&](const Viewpoint& a, const Viewpoint& b) { return off_m(a) < off_m(b); })
        ->pose.position_m();
  }

  void search(const Ground& coarse, const Eigen::Vector2d& p_m) {
    const Sweep sweep(coarse, p_m);
    Search search{p_m, {}};
    for (const Viewpoint& v : viewpoints_) {
      search.length_m.push_back(sweep.length_m(v.pose.position_m()).value_or(kNoWay));
    }
    searches_.push_back(std::move(search));
  }

  std::vector<Viewpoint> viewpoints_;
  std::vector<std::size_t> source_;  ///< of each viewpoint, into searches_
  std::vector<tour::Cluster> nodes_;
  std::vector<int> starts_;
  std::vector<Search> searches_;  ///< from the robots, then from the clusters
};

using Orders = std::vector<std::vector<int>>;

Orders by_time(const tour::ClusterGraph& graph, const std::vector<Cluster>& clusters,
               const std::vector<RobotPlace>& robots, const AllocationParams& params, const VisitTimes& times) {
  tour::Arcs legs_s = graph.durations_s(times.speed_mps);
  for (int v = 0; v < graph.size(); ++v) {
    const double visits_s =
        times.visit_s * static_cast<double>(clusters[static_cast<std::size_t>(v)].viewpoints.size());
    for (int u = 0; u < graph.size(); ++u) legs_s.among(u, v) += visits_s;
    for (int r = 0; r < graph.robots(); ++r) {
      legs_s.from_start(r, v) += visits_s + robots[static_cast<std::size_t>(r)].busy_s;
    }
  }
  return tour::timed_tours(legs_s, graph.gains(), params.time).order;
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

/// Of what a robot was given, what completes most per second comes first (as for a robot alone: tour_planner.cpp).
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
