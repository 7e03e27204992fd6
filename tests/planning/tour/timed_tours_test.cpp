// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/timed_tours.h"

#include <gtest/gtest.h>

#include <limits>

#include "common/error.h"
#include "tests/planning/tour/problems.h"

namespace arpent::tour {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> random_gains(int n, unsigned seed) {
  return first_row(random_costs(n + 1, 0, seed).block(n, 0, 1, n).eval());
}

Arcs random_legs(int n, int robots, unsigned seed) {
  const Matrix all = random_costs(n + robots, 3, seed);
  return {all.topLeftCorner(n, n), all.block(n, 0, robots, n)};
}

TEST(TourTimed, OneRobotsTourIsThatOfBruteForce) {
  for (int n = 1; n <= 8; ++n) {
    for (const double weight : {0.0, 1.0, 5.0}) {
      const Arcs legs_s = random_legs(n, 1, 1);
      const std::vector<double> gain = random_gains(n, 2);
      TimedParams params;
      params.completion_weight = weight;
      const TimedTours tours = timed_tours(legs_s, gain, params);
      ASSERT_TRUE(is_permutation_of(tours.order[0], n));
      EXPECT_NEAR(tours.objective_s,
                  least_over_permutations(
                      n, [&](const auto& order) { return evaluate_timed(legs_s, gain, params, {order}).objective_s; }),
                  1e-12);
    }
  }
}

/// All ways to split 6 clusters among 2 robots: each order of 6, cut anywhere.
TEST(TourTimed, TwoRobotsToursAreThoseOfBruteForce) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Arcs legs_s = random_legs(6, 2, seed);
    const std::vector<double> gain = random_gains(6, seed);
    TimedParams params;
    params.steps = 1e5;
    const double best = least_over_permutations(6, [&](const auto& order) {
      double least = kInfinity;
      for (auto cut = order.begin();; ++cut) {
        least = std::min(least,
                         evaluate_timed(legs_s, gain, params, {{order.begin(), cut}, {cut, order.end()}}).objective_s);
        if (cut == order.end()) return least;
      }
    });
    EXPECT_NEAR(timed_tours(legs_s, gain, params).objective_s, best, 1e-9) << "seed " << seed;
  }
}

/// One robot, clusters at 1 (gain 1) and -2 (gain 3) on a line, 1 m/s. First 1: arrivals 1 and 4, mean (1 + 12) / 4
/// = 3.25, end 4. First -2: arrivals 2 and 5, mean (6 + 5) / 4 = 2.75, end 5.
TEST(TourTimed, TheCompletionWeightTradesArrivalsForTheEndByHand) {
  Arcs legs_s{Matrix(2, 2), Matrix(1, 2)};
  legs_s.among << 0, 3, 3, 0;
  legs_s.from_start << 1, 2;
  TimedParams early, end;
  early.completion_weight = 0.4;
  end.completion_weight = 0.6;
  const TimedTours a = timed_tours(legs_s, {1, 3}, early), b = timed_tours(legs_s, {1, 3}, end);
  EXPECT_EQ(a.order[0], (std::vector<int>{1, 0}));
  EXPECT_NEAR(a.mean_arrival_s, 2.75, 1e-12);
  EXPECT_NEAR(a.objective_s, 2.75 + 0.4 * 5, 1e-12);
  EXPECT_EQ(b.order[0], (std::vector<int>{0, 1}));
  EXPECT_NEAR(b.completion_s, 4, 1e-12);
}

TEST(TourTimed, SearchEqualsTheExactTourOfTwelveClusters) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Arcs one = random_legs(12, 1, seed);
    const std::vector<double> gain = random_gains(12, seed);
    const double exact = timed_tours(one, gain, {}).objective_s;
    // A second robot that cannot reach anything makes it a team problem, which is searched.
    Arcs two{one.among, Matrix(2, 12)};
    two.from_start << one.from_start, Matrix::Constant(1, 12, kInfinity);
    const TimedTours searched = timed_tours(two, gain, {});
    EXPECT_TRUE(searched.order[1].empty());
    EXPECT_NEAR(searched.objective_s, exact, 1e-9) << "seed " << seed;
  }
}

TEST(TourTimed, MoreStepsAreNeverWorseAndTheSameStepsAreTheSameTours) {
  const Arcs legs_s = random_legs(40, 3, 3);
  const std::vector<double> gain = random_gains(40, 3);
  double last = kInfinity;
  for (const double steps : {0.0, 1e4, 1e5, 4e5}) {
    TimedParams params;
    params.steps = steps;
    const TimedTours tours = timed_tours(legs_s, gain, params);
    EXPECT_LE(tours.objective_s, last);
    EXPECT_EQ(tours.order, timed_tours(legs_s, gain, params).order);
    last = tours.objective_s;
  }
}

TEST(TourTimed, AWarmStartIsNeverMadeWorse) {
  const Arcs legs_s = random_legs(25, 2, 4);
  const std::vector<double> gain = random_gains(25, 4);
  const TimedTours good = timed_tours(legs_s, gain, {});
  TimedParams none;
  none.steps = 0;
  EXPECT_EQ(timed_tours(legs_s, gain, none, good.order).order, good.order);
}

TEST(TourTimed, TwoRobotsAtTheEndsOfARowShareItsClusters) {
  constexpr int kClusters = 14;
  Arcs legs_s{Matrix(kClusters, kClusters), Matrix(2, kClusters)};
  for (int v = 0; v < kClusters; ++v) {
    for (int u = 0; u < kClusters; ++u) legs_s.among(u, v) = std::abs(u - v);
    legs_s.from_start.col(v) << v + 1, kClusters - v;
  }
  const TimedTours tours = timed_tours(legs_s, std::vector<double>(kClusters, 1.0), {});
  EXPECT_EQ(tours.completion_s, 7);
  EXPECT_EQ(tours.order[0], (std::vector<int>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(tours.order[1], (std::vector<int>{13, 12, 11, 10, 9, 8, 7}));
}

TEST(TourTimed, ClustersWithoutAWayAreNamed) {
  Arcs legs_s = random_legs(5, 2, 5);
  legs_s.from_start.col(3).setConstant(kInfinity);
  legs_s.among.col(3).setConstant(kInfinity);
  legs_s.among.row(3).setConstant(kInfinity);
  const TimedTours tours = timed_tours(legs_s, {1, 1, 1, 1, 1}, {});
  EXPECT_EQ(tours.unreachable, (std::vector<int>{3}));
  EXPECT_EQ(tours.order[0].size() + tours.order[1].size(), 4U);
  EXPECT_LT(tours.objective_s, 100);
}

TEST(TourTimed, NegativeTimesAndGainsAreRefused) {
  Arcs legs_s = random_legs(3, 1, 6);
  EXPECT_THROW((void)timed_tours(legs_s, {1, -1, 1}, {}), InputError);
  legs_s.among(0, 1) = -1;
  EXPECT_THROW((void)timed_tours(legs_s, {1, 1, 1}, {}), InputError);
}

}  // namespace
}  // namespace arpent::tour
