// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/tour_planner.h"

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

/// Viewpoints by number, cluster after cluster; the robot comes last.
struct Places {
  std::vector<Eigen::Vector2d> p_m;
  std::vector<std::size_t> cluster;
};

/// Lengths of drives: from the robot and from a middle viewpoint of each cluster they are searched, others follow from
/// those by the triangle's inequality.
class Prices {
 public:
  Prices(const Ground& ground, const std::vector<Cluster>& clusters, const Places& places, const Pose2& robot)
      : places_(places) {
    const Ground coarse = halve(ground);
    search(coarse, robot.position_m());
    for (const Cluster& cluster : clusters) search(coarse, middle_of(cluster));
  }

  [[nodiscard]] double operator()(int from, int to) const {
    const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
    const bool robot = a + 1 == places_.p_m.size();
    const double straight = (places_.p_m[a] - places_.p_m[b]).norm();
    if (!robot && places_.cluster[a] == places_.cluster[b]) return kDetour * straight;
    const Source& source = sources_[robot ? 0 : 1 + places_.cluster[a]];
    return std::max(straight, source.length_m[b] - (places_.p_m[a] - source.p_m).norm());
  }

 private:
  struct Source {
    Eigen::Vector2d p_m;
    std::vector<double> length_m;  ///< to each place
  };

  static Eigen::Vector2d middle_of(const Cluster& cluster) {
    const auto nearest = std::min_element(
        cluster.viewpoints.begin(), cluster.viewpoints.end(), [&](const Viewpoint& a, const Viewpoint& b) {
          return (a.pose.position_m() - cluster.centre_m).norm() < (b.pose.position_m() - cluster.centre_m).norm();
        });
    return nearest->pose.position_m();
  }

  void search(const Ground& coarse, const Eigen::Vector2d& p_m) {
    const Sweep sweep(coarse, p_m);
    Source source{p_m, {}};
    for (const Eigen::Vector2d& place : places_.p_m) source.length_m.push_back(sweep.length_m(place).value_or(kNoWay));
    sources_.push_back(std::move(source));
  }

  const Places& places_;
  std::vector<Source> sources_;
};

tour::Arcs add_visits(tour::Arcs arcs, const std::vector<Cluster>& clusters, double visit_s) {
  for (int v = 0; v < static_cast<int>(clusters.size()); ++v) {
    const double visits_s = visit_s * static_cast<double>(clusters[static_cast<std::size_t>(v)].viewpoints.size());
    for (int u = 0; u < static_cast<int>(clusters.size()); ++u) arcs.among(u, v) += visits_s;
    arcs.from_start(0, v) += visits_s;
  }
  return arcs;
}

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

Ground halve(const Ground& ground) {
  const GridFrame& fine = ground.frame();
  GridFrame frame;
  frame.cell_m = 2 * fine.cell_m;
  frame.first = {fine.first.x() >> 1, fine.first.y() >> 1};
  const Eigen::Vector2i last = fine.first + Eigen::Vector2i(fine.cols - 1, fine.rows - 1);
  frame.cols = (last.x() >> 1) - frame.first.x() + 1;
  frame.rows = (last.y() >> 1) - frame.first.y() + 1;
  std::vector<CellState> states(frame.size(), CellState::kUnknown);
  for (int j = 0; j < frame.rows; ++j) {
    for (int i = 0; i < frame.cols; ++i) {
      bool unknown = false, occupied = false;
      for (int k = 0; k < 4; ++k) {
        const int u = 2 * (frame.first.x() + i) - fine.first.x() + (k & 1);
        const int v = 2 * (frame.first.y() + j) - fine.first.y() + (k >> 1);
        const CellState state = fine.has(u, v) ? ground.state(fine.centre_m(u, v)) : CellState::kUnknown;
        unknown = unknown || state == CellState::kUnknown;
        occupied = occupied || state == CellState::kOccupied;
      }
      states[frame.at(i, j)] = occupied ? CellState::kOccupied : unknown ? CellState::kUnknown : CellState::kFree;
    }
  }
  return Ground(frame, std::move(states), ground.footprint(), ground.costs());
}

PlannedTour plan_tour(const Ground& ground, const std::vector<Cluster>& clusters, const Pose2& robot,
                      const TourParams& params, const VisitTimes& times) {
  PlannedTour planned;
  Places places;
  std::vector<tour::Cluster> nodes;
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    tour::Cluster node{{}, clusters[c].gain};
    for (const Viewpoint& viewpoint : clusters[c].viewpoints) {
      node.viewpoints.push_back(static_cast<int>(places.p_m.size()));
      places.p_m.push_back(viewpoint.pose.position_m());
      places.cluster.push_back(c);
      planned.viewpoints.push_back(viewpoint);
    }
    nodes.push_back(std::move(node));
  }
  const int start = static_cast<int>(places.p_m.size());
  places.p_m.push_back(robot.position_m());
  places.cluster.push_back(clusters.size());
  const Prices prices(ground, clusters, places, robot);
  const tour::ClusterGraph graph(nodes, {start}, prices);
  const tour::Arcs durations_s = add_visits(graph.durations_s(times.speed_mps), clusters, times.visit_s);
  const auto [order, completion_s] = params.objective == "time" ? order_by_time(graph, durations_s, params.time)
                                                                : order_by_utility(graph, durations_s, params);
  for (const int viewpoint : graph.viewpoints(0, order)) {
    planned.tour.targets.push_back({viewpoint, planned.viewpoints[static_cast<std::size_t>(viewpoint)].pose});
  }
  // What the first cluster is for decides when to plan anew; the others are where to go if it cannot be reached.
  if (!order.empty()) planned.tour.elements = clusters[static_cast<std::size_t>(order.front())].elements;
  planned.completion_s = completion_s;
  return planned;
}

}  // namespace arpent::planning
