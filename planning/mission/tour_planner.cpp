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
/// Nearer than this a viewpoint is turned to, not driven to.
constexpr double kNearM = 0.1;

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

/// A tour visits what lies near first, however little it is worth, and by the time that it gets to the rest the map has
/// changed. So the first target is the one that completes most per second; the tour orders the others.
void put_best_first(PlannedTour& planned, const Prices& prices, const Pose2& robot, const VisitTimes& times) {
  std::vector<TourTarget>& targets = planned.tour.targets;
  const int start = static_cast<int>(planned.viewpoints.size());
  double best_rate = 0;
  std::size_t best = 0;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Viewpoint& viewpoint = planned.viewpoints[static_cast<std::size_t>(targets[i].id)];
    const double rate = rate_of(viewpoint, prices(start, static_cast<int>(targets[i].id)), robot, times);
    if (rate <= best_rate) continue;
    best_rate = rate;
    best = i;
  }
  const auto at = targets.begin() + static_cast<std::ptrdiff_t>(best);
  if (!targets.empty()) std::rotate(targets.begin(), at, at + 1);
}

tour::Arcs add_visits(tour::Arcs arcs, const std::vector<Cluster>& clusters, double visit_s) {
  for (int v = 0; v < static_cast<int>(clusters.size()); ++v) {
    const double visits_s = visit_s * static_cast<double>(clusters[static_cast<std::size_t>(v)].viewpoints.size());
    for (int u = 0; u < static_cast<int>(clusters.size()); ++u) arcs.among(u, v) += visits_s;
    arcs.from_start(0, v) += visits_s;
  }
  return arcs;
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
                      const tour::TimedParams& params, const VisitTimes& times) {
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
  const tour::TimedTours tours =
      tour::timed_tours(add_visits(graph.durations_s(times.speed_mps), clusters, times.visit_s), graph.gains(), params);
  std::vector<int> order = tours.order.front();
  order.insert(order.end(), tours.unreachable.begin(), tours.unreachable.end());
  for (const int viewpoint : graph.viewpoints(0, order)) {
    planned.tour.targets.push_back({viewpoint, planned.viewpoints[static_cast<std::size_t>(viewpoint)].pose});
  }
  put_best_first(planned, prices, robot, times);
  // What the first cluster is for decides when to plan anew; the others are where to go if it cannot be reached.
  if (!order.empty()) planned.tour.elements = clusters[static_cast<std::size_t>(order.front())].elements;
  planned.completion_s = tours.completion_s;
  return planned;
}

}  // namespace arpent::planning
