// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Makes tour_truth.csv: the best known utility of each case. Up to 16 clusters exact; above, the best of long runs of
// two different methods, the benched local search and ruin and recreate (as a path of shifted costs F - f, whose time
// to the end is what it minimises). `other` is what the other method found alone, `bound` what no path exceeds.
#include <cstdio>

#include "bench/planning/tour_instances.h"
#include "planning/tour/max_atsp.h"
#include "planning/tour/timed_tours.h"

namespace {

using namespace arpent;

constexpr double kLambdaIc1pm = 0.01;
constexpr double kLongSteps = 3e8;

double ruin_and_recreate(const tour::Arcs& utility) {
  const double most = std::max(utility.among.maxCoeff(), utility.from_start.maxCoeff());
  const tour::Arcs shifted{(most - utility.among.array()).matrix(), (most - utility.from_start.array()).matrix()};
  const std::vector<double> no_gain(static_cast<std::size_t>(utility.among.rows()), 0.0);
  tour::TimedParams params;
  params.steps = kLongSteps / 10;
  const auto order = tour::timed_tours(shifted, no_gain, params).order[0];
  return tour::path_utility(bench::from_only_start(utility), utility.among, order);
}

}  // namespace

int main() {
  std::printf("clusters,lambda_tc_1pm,seed,best,other,bound\n");
  for (const bench::TourCase& c : bench::tour_cases()) {
    const tour::Arcs utility = bench::random_clusters(c.clusters, 1, c.seed).utilities(c.lambda_tc_1pm, kLambdaIc1pm);
    const tour::OpenTour tour = tour::max_atsp(bench::from_only_start(utility), utility.among, {16, kLongSteps, 5000});
    const double other = ruin_and_recreate(utility);
    std::printf("%d,%g,%u,%.15g,%.15g,%.15g\n", c.clusters, c.lambda_tc_1pm, c.seed, std::max(tour.value, other), other,
                tour.bound);
    std::fflush(stdout);
  }
  return 0;
}
