// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// maxATSP (thesis Sect. 2.5.2, eq. 2.4): the path of greatest utility from a robot's start through all clusters, each
// once, with a free end. Exact for few clusters, local search above, with an upper bound on what any path can be worth.
// Also the closed tour of least cost, on the same solver.
#pragma once

#include <functional>
#include <vector>

#include "common/config/fields.h"
#include "planning/tour/matrix.h"

namespace arpent::tour {

struct SolverParams {
  int exact_up_to = 12;
  double steps = 7e6;
  int bound_iterations = 500;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("exact_up_to", self.exact_up_to, "clusters up to which a tour is exact", config::between(0, 16));
    visitor.field("steps", self.steps,
                  "candidate arcs that the local search looks at and nodes it moves (7e6 take about 50 ms)",
                  config::between(0.0, 1e12));
    visitor.field("bound_iterations", self.bound_iterations, "iterations for the bound; 0: the assignment bound",
                  config::between(0, 100000));
  }
};

struct OpenTour {
  std::vector<int> order;  ///< clusters in the order of the visits
  double value = 0;        ///< sum of the utilities of its arcs
  double bound = 0;        ///< no path is worth more; equal to value if the path is proven best
};

/// `from_start`: utility of the arcs from the start, one per cluster; `among`: n x n, row to column. All finite, else
/// InputError. `warm`: a path through some of the clusters to begin with (e.g. the last one, without a new cluster);
/// the result is never worse than inserting the missing ones into it. Empty: begins with the nearest-neighbour path. No
/// clusters: an empty path worth 0.
[[nodiscard]] OpenTour max_atsp(const std::vector<double>& from_start, const Matrix& among, const SolverParams& params,
                                const std::vector<int>& warm = {});

/// The baseline: always on to the cluster of greatest utility, ties to the first. The bound is not computed (infinite).
[[nodiscard]] OpenTour nearest_neighbour_tour(const std::vector<double>& from_start, const Matrix& among);

/// Utility of the arcs along `order`.
[[nodiscard]] double path_utility(const std::vector<double>& from_start, const Matrix& among,
                                  const std::vector<int>& order);

struct ClosedTour {
  std::vector<int> order;  ///< from node 0
  double cost = 0;
  double bound = 0;  ///< no tour costs less
  double steps = 0;  ///< taken by the local search; 0 if the tour is exact
};

/// Is asked between two pieces of a search, with the steps taken so far, for the total to go on to; the search ends
/// when the answer is no more than what was taken. Lets a program with a deadline choose the number of steps as it
/// goes.
using StepBudget = std::function<double(double steps_taken)>;

/// Closed tour of least cost; `cost` is n x n, n >= 1, finite off the diagonal (which is ignored), else InputError.
/// `budget` takes the place of `params.steps`.
[[nodiscard]] ClosedTour min_atsp(const Matrix& cost, const SolverParams& params, const StepBudget& budget = {});

}  // namespace arpent::tour
