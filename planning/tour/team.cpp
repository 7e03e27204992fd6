// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/team.h"

#include <algorithm>
#include <numeric>

#include "common/error.h"

namespace arpent::tour {
namespace {

/// maxATSP of one robot over `clusters`, begun from the tour through the first `known` of them.
OpenTour solve_for(const Arcs& utility, int robot, const std::vector<int>& clusters, std::size_t known,
                   const SolverParams& params) {
  const auto count = static_cast<Eigen::Index>(clusters.size());
  std::vector<double> from_start;
  Matrix among(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    from_start.push_back(utility.from_start(robot, clusters[static_cast<std::size_t>(i)]));
    for (Eigen::Index j = 0; j < count; ++j) {
      among(i, j) = utility.among(clusters[static_cast<std::size_t>(i)], clusters[static_cast<std::size_t>(j)]);
    }
  }
  std::vector<int> warm(known);
  std::iota(warm.begin(), warm.end(), 0);
  OpenTour tour = max_atsp(from_start, among, params, warm);
  for (int& v : tour.order) v = clusters[static_cast<std::size_t>(v)];
  return tour;
}

std::vector<int> by_distance(const Matrix& start_distance_m) {
  std::vector<int> ranked(static_cast<std::size_t>(start_distance_m.cols()));
  std::iota(ranked.begin(), ranked.end(), 0);
  std::stable_sort(ranked.begin(), ranked.end(), [&](int a, int b) {
    return start_distance_m.col(a).minCoeff() < start_distance_m.col(b).minCoeff();
  });
  return ranked;
}

}  // namespace

std::vector<OpenTour> tsga(const Arcs& utility, const Matrix& start_distance_m, const TsgaParams& params) {
  const auto robots = static_cast<std::size_t>(utility.from_start.rows());
  ARPENT_ASSERT(robots >= 1 && start_distance_m.rows() == utility.from_start.rows() &&
                start_distance_m.cols() == utility.from_start.cols());
  std::vector<OpenTour> tours(robots);  // the order holds U^i, the value p^i
  for (const int v : by_distance(start_distance_m)) {
    std::size_t winner = 0;
    OpenTour won;
    for (std::size_t k = 0; k < robots; ++k) {
      std::vector<int> clusters = tours[k].order;
      clusters.push_back(v);
      OpenTour trial = solve_for(utility, static_cast<int>(k), clusters, clusters.size() - 1, params.trial);
      if (k > 0 && trial.value - tours[k].value <= won.value - tours[winner].value) continue;
      winner = k;
      won = std::move(trial);
    }
    tours[winner] = std::move(won);
  }
  for (std::size_t k = 0; k < robots; ++k) {
    const std::vector<int> clusters = tours[k].order;
    tours[k] = solve_for(utility, static_cast<int>(k), clusters, clusters.size(), params.final);
  }
  return tours;
}

std::vector<int> nearest_neighbour_picks(const Matrix& utility_from_start, bool share) {
  std::vector<int> picks;
  std::vector<char> taken(static_cast<std::size_t>(utility_from_start.cols()), 0);
  for (Eigen::Index robot = 0; robot < utility_from_start.rows(); ++robot) {
    int best = -1;
    for (int v = 0; v < static_cast<int>(taken.size()); ++v) {
      if (taken[static_cast<std::size_t>(v)] != 0) continue;
      if (best < 0 || utility_from_start(robot, v) > utility_from_start(robot, best)) best = v;
    }
    picks.push_back(best);
    if (best >= 0 && !share) taken[static_cast<std::size_t>(best)] = 1;
  }
  return picks;
}

}  // namespace arpent::tour
