// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/max_atsp.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/error.h"
#include "planning/tour/atsp_search.h"
#include "planning/tour/held_karp.h"
#include "planning/tour/lower_bound.h"

namespace arpent::tour {
namespace {

void check_finite(const Matrix& matrix, const char* what) {
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      if (i == j || std::isfinite(matrix(i, j))) continue;
      throw InputError(std::string(what) + " of arc " + std::to_string(i) + " to " + std::to_string(j) +
                       " is not finite");
    }
  }
}

/// Node 0 is the start, node v + 1 is cluster v. All paths have as many arcs, so that the least sum of -f is the
/// greatest of f; the way back to the start costs nothing.
Matrix closed_form(const std::vector<double>& from_start, const Matrix& among) {
  const auto n = static_cast<Eigen::Index>(from_start.size());
  ARPENT_ASSERT(among.rows() == n && among.cols() == n);
  Matrix cost = Matrix::Zero(n + 1, n + 1);
  cost.bottomRightCorner(n, n) = -among;
  for (Eigen::Index v = 0; v < n; ++v) cost(0, v + 1) = -from_start[static_cast<std::size_t>(v)];
  check_finite(cost, "tour: the utility");
  return cost;
}

void rotate_to_0(std::vector<int>& tour) {
  std::rotate(tour.begin(), std::find(tour.begin(), tour.end(), 0), tour.end());
}

/// The assignment's multipliers choose the candidate arcs: on the bench's cases they do better than the Held-Karp ones.
ClosedTour search(const Matrix& cost, const SolverParams& params, const StepBudget& budget, std::vector<int> first) {
  const Bound bound = assignment_bound(cost);
  AtspSearch search(cost, bound, insert_missing(cost, std::move(first)));
  for (double goal = budget ? budget(0) : params.steps;;) {
    search.run_until(static_cast<std::int64_t>(goal));
    if (search.proven() || !budget) break;
    goal = budget(static_cast<double>(search.steps()));
    if (goal <= static_cast<double>(search.steps())) break;
  }
  ClosedTour result{search.best(), search.best_cost(), bound.value, static_cast<double>(search.steps())};
  if (!search.proven()) result.bound = held_karp_bound(cost, bound, result.cost, params.bound_iterations).value;
  rotate_to_0(result.order);
  result.bound = std::min(result.bound, result.cost);
  return result;
}

ClosedTour solve(const Matrix& cost, const SolverParams& params, const StepBudget& budget, std::vector<int> first) {
  if (cost.rows() > params.exact_up_to + 1) return search(cost, params, budget, std::move(first));
  ClosedTour result;
  result.order = exact_tour(cost);
  if (cost.rows() > 1) result.cost = closed_cost(cost, result.order);
  result.bound = result.cost;
  return result;
}

}  // namespace

OpenTour max_atsp(const std::vector<double>& from_start, const Matrix& among, const SolverParams& params,
                  const std::vector<int>& warm) {
  const Matrix cost = closed_form(from_start, among);
  std::vector<int> first = {0};
  for (const int v : warm.empty() ? nearest_neighbour_tour(from_start, among).order : warm) first.push_back(v + 1);
  const ClosedTour closed = solve(cost, params, {}, std::move(first));
  OpenTour tour;
  for (std::size_t i = 1; i < closed.order.size(); ++i) tour.order.push_back(closed.order[i] - 1);
  tour.value = path_utility(from_start, among, tour.order);
  tour.bound = std::max(tour.value, -closed.bound);
  return tour;
}

OpenTour nearest_neighbour_tour(const std::vector<double>& from_start, const Matrix& among) {
  OpenTour tour;
  tour.bound = std::numeric_limits<double>::infinity();
  std::vector<char> visited(from_start.size(), 0);
  for (std::size_t i = 0; i < from_start.size(); ++i) {
    int best = -1;
    const auto worth = [&](int v) {
      return tour.order.empty() ? from_start[static_cast<std::size_t>(v)] : among(tour.order.back(), v);
    };
    for (int v = 0; v < static_cast<int>(from_start.size()); ++v) {
      if (visited[static_cast<std::size_t>(v)] == 0 && (best < 0 || worth(v) > worth(best))) best = v;
    }
    visited[static_cast<std::size_t>(best)] = 1;
    tour.order.push_back(best);
  }
  tour.value = path_utility(from_start, among, tour.order);
  return tour;
}

double path_utility(const std::vector<double>& from_start, const Matrix& among, const std::vector<int>& order) {
  double sum = order.empty() ? 0.0 : from_start[static_cast<std::size_t>(order.front())];
  for (std::size_t i = 1; i < order.size(); ++i) sum += among(order[i - 1], order[i]);
  return sum;
}

ClosedTour min_atsp(const Matrix& cost, const SolverParams& params, const StepBudget& budget) {
  ARPENT_ASSERT(cost.rows() == cost.cols() && cost.rows() >= 1);
  check_finite(cost, "tour: the cost");
  return solve(cost, params, budget, {0});
}

}  // namespace arpent::tour
