// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/roads.h"

#include <algorithm>
#include <limits>

#include "planning/local/sweep.h"

namespace arpent::planning {
namespace {

constexpr double kNoWay = std::numeric_limits<double>::infinity();
/// Drives within a cluster are short: the straight line, and a little more for what is in between.
constexpr double kDetour = 1.15;

Eigen::Vector2d middle_of(const Cluster& cluster) {
  const auto off_m = [&](const Viewpoint& v) { return (v.pose.position_m() - cluster.centre_m).norm(); };
  return std::min_element(cluster.viewpoints.begin(), cluster.viewpoints.end(),
                          [&](const Viewpoint& a, const Viewpoint& b) { return off_m(a) < off_m(b); })
      ->pose.position_m();
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

Roads::Roads(const Ground& ground, const std::vector<Cluster>& clusters, std::span<const RobotPlace> robots) {
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

double Roads::operator()(int from, int to) const {
  const auto a = static_cast<std::size_t>(from), b = static_cast<std::size_t>(to);
  if (a >= viewpoints_.size()) return searches_[a - viewpoints_.size()].length_m[b];
  const double straight = straight_m(from, to);
  if (source_[a] == source_[b]) return kDetour * straight;
  const Search& search = searches_[source_[a]];
  return std::max(straight, search.length_m[b] - (position_m(a) - search.p_m).norm());
}

double Roads::straight_m(int from, int to) const {
  return (position_m(static_cast<std::size_t>(from)) - position_m(static_cast<std::size_t>(to))).norm();
}

void Roads::search(const Ground& coarse, const Eigen::Vector2d& p_m) {
  const Sweep sweep(coarse, p_m);
  Search search{p_m, {}};
  for (const Viewpoint& v : viewpoints_) {
    search.length_m.push_back(sweep.length_m(v.pose.position_m()).value_or(kNoWay));
  }
  searches_.push_back(std::move(search));
}

Eigen::Vector2d Roads::position_m(std::size_t number) const {
  return number < viewpoints_.size() ? viewpoints_[number].pose.position_m()
                                     : searches_[number - viewpoints_.size()].p_m;
}

tour::Arcs visit_durations_s(const tour::ClusterGraph& graph, const std::vector<Cluster>& clusters,
                             std::span<const RobotPlace> robots, const VisitTimes& times) {
  tour::Arcs legs_s = graph.durations_s(times.speed_mps);
  for (int v = 0; v < graph.size(); ++v) {
    const double visits_s =
        times.visit_s * static_cast<double>(clusters[static_cast<std::size_t>(v)].viewpoints.size());
    for (int u = 0; u < graph.size(); ++u) legs_s.among(u, v) += visits_s;
    for (int r = 0; r < graph.robots(); ++r) {
      legs_s.from_start(r, v) += visits_s + robots[static_cast<std::size_t>(r)].busy_s;
    }
  }
  return legs_s;
}

}  // namespace arpent::planning
