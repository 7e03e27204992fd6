// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/max_atsp.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/error.h"
#include "tests/planning/tour/problems.h"

namespace arpent::tour {
namespace {

SolverParams local_search(double steps = 300000) {
  SolverParams params;
  params.exact_up_to = 0;
  params.steps = steps;
  return params;
}

TEST(TourMaxAtsp, ExactPathsAreThoseOfBruteForce) {
  for (int n = 1; n <= 8; ++n) {
    const Matrix among = random_costs(n, 0, 1);
    const std::vector<double> start = first_row(random_costs(n + 1, 0, 2).bottomRows(1));
    const std::vector<double> from_start(start.begin(), start.begin() + n);
    const OpenTour tour = max_atsp(from_start, among, {});
    ASSERT_TRUE(is_permutation_of(tour.order, n));
    EXPECT_NEAR(tour.value,
                -least_over_permutations(n, [&](const auto& order) { return -path_utility(from_start, among, order); }),
                1e-12);
    EXPECT_EQ(tour.bound, tour.value);
  }
}

TEST(TourMaxAtsp, LocalSearchEqualsTheExactPathUpToThirteenClusters) {
  for (int n = 1; n <= 13; ++n) {
    for (int kind = 0; kind < 4; ++kind) {
      const Matrix among = random_costs(n, kind, 3);
      const std::vector<double> from_start = first_row(among);
      SolverParams exact;
      exact.exact_up_to = 13;
      const OpenTour truth = max_atsp(from_start, among, exact), found = max_atsp(from_start, among, local_search());
      EXPECT_NEAR(found.value, truth.value, 1e-9) << n << " clusters, kind " << kind;
      EXPECT_GE(found.bound, truth.value - 1e-9);
    }
  }
}

TEST(TourMaxAtsp, NoClustersAreWorthNothing) {
  const OpenTour tour = max_atsp({}, Matrix(0, 0), {});
  EXPECT_TRUE(tour.order.empty());
  EXPECT_EQ(tour.value, 0);
  EXPECT_EQ(tour.bound, 0);
}

TEST(TourMaxAtsp, NamesOfTheClustersDoNotMatter) {
  constexpr int kClusters = 12;
  const Matrix among = random_costs(kClusters, 0, 4);
  const std::vector<double> from_start = first_row(among);
  std::vector<int> name = counting(kClusters);
  std::mt19937_64 random(9);
  std::shuffle(name.begin(), name.end(), random);
  Matrix renamed(kClusters, kClusters);
  std::vector<double> renamed_start(kClusters);
  for (int i = 0; i < kClusters; ++i) {
    renamed_start[static_cast<std::size_t>(name[static_cast<std::size_t>(i)])] =
        from_start[static_cast<std::size_t>(i)];
    for (int j = 0; j < kClusters; ++j) {
      renamed(name[static_cast<std::size_t>(i)], name[static_cast<std::size_t>(j)]) = among(i, j);
    }
  }
  for (const SolverParams& params : {SolverParams{}, local_search()}) {
    EXPECT_NEAR(max_atsp(from_start, among, params).value, max_atsp(renamed_start, renamed, params).value, 1e-12);
  }
}

TEST(TourMaxAtsp, ANewClusterAtTheEndAlwaysGains) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Matrix among = random_costs(20, 0, seed);
    const std::vector<double> all = first_row(among);
    const OpenTour without = max_atsp({all.begin(), all.end() - 1}, among.topLeftCorner(19, 19), local_search());
    const OpenTour with = max_atsp(all, among, local_search(0), without.order);
    EXPECT_GE(with.value, without.value + among.col(19).head(19).minCoeff());
  }
}

TEST(TourMaxAtsp, MoreStepsAreNeverWorseAndTheSameStepsAreTheSamePath) {
  const Matrix among = random_costs(45, 3, 5);
  const std::vector<double> from_start = first_row(among);
  double last = 0;
  for (const double steps : {3e4, 1e5, 3e5, 1e6}) {
    const OpenTour tour = max_atsp(from_start, among, local_search(steps));
    EXPECT_GE(tour.value, last);
    EXPECT_GE(tour.bound, tour.value);
    EXPECT_EQ(tour.order, max_atsp(from_start, among, local_search(steps)).order);
    last = tour.value;
  }
}

/// From the start: 0 is worth 3, 1 worth 5, 2 worth 4; after 1 greed takes 0 (2 over 1), which leaves 2 at 1: 5 + 2 + 1
/// = 8. The best path is 2, 0, 1: 4 + 6 + 5 = 15.
TEST(TourMaxAtsp, NearestNeighboursAreGreedy) {
  Matrix among(3, 3);
  among << 0, 5, 1,  //
      2, 0, 1,       //
      6, 1, 0;
  const std::vector<double> from_start = {3, 5, 4};
  const OpenTour greedy = nearest_neighbour_tour(from_start, among), best = max_atsp(from_start, among, {});
  EXPECT_EQ(greedy.order, (std::vector<int>{1, 0, 2}));
  EXPECT_EQ(greedy.value, 8);
  EXPECT_EQ(best.order, (std::vector<int>{2, 0, 1}));
  EXPECT_EQ(best.value, 15);
}

TEST(TourMaxAtsp, WhatIsNotFiniteIsRefused) {
  Matrix among = random_costs(4, 0, 1);
  among(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)max_atsp({1, 1, 1, 1}, among, {}), InputError);
  EXPECT_THROW((void)min_atsp(among, {}), InputError);
}

}  // namespace
}  // namespace arpent::tour
