// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "planning/tour/atsp_search.h"
#include "planning/tour/held_karp.h"
#include "planning/tour/lower_bound.h"
#include "planning/tour/max_atsp.h"
#include "tests/planning/tour/problems.h"

namespace arpent::tour {
namespace {

constexpr int kKinds = 4;

AtspSearch search(const Matrix& cost, std::uint64_t seed = 1) {
  return {cost, assignment_bound(cost), counting(static_cast<int>(cost.rows())), seed};
}

TEST(TourAtsp, ExactToursAreThoseOfBruteForce) {
  for (int n = 1; n <= 8; ++n) {
    for (int kind = 0; kind < kKinds; ++kind) {
      const Matrix cost = random_costs(n, kind, 1);
      const std::vector<int> tour = exact_tour(cost);
      ASSERT_TRUE(is_permutation_of(tour, n));
      EXPECT_EQ(tour.front(), 0);
      EXPECT_NEAR(closed_cost(cost, tour),
                  least_over_permutations(n, [&](const auto& order) { return closed_cost(cost, order); }), 1e-12);
    }
  }
}

TEST(TourAtsp, TheAssignmentBoundIsTheBestAssignmentOfBruteForce) {
  for (int n = 2; n <= 7; ++n) {
    for (int kind = 0; kind < kKinds; ++kind) {
      const Matrix cost = random_costs(n, kind, 2);
      const double least = least_over_permutations(n, [&](const auto& to) {
        double sum = 0;
        for (int i = 0; i < n; ++i)
          sum += to[static_cast<std::size_t>(i)] == i ? 1e9 : cost(i, to[static_cast<std::size_t>(i)]);
        return sum;
      });
      const Bound bound = assignment_bound(cost);
      EXPECT_NEAR(bound.value, least, 1e-12);
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          if (i == j) continue;
          const auto row = static_cast<std::size_t>(i), column = static_cast<std::size_t>(j);
          EXPECT_GE(cost(i, j) - bound.out[row] - bound.in[column], -1e-12);
        }
      }
    }
  }
}

TEST(TourAtsp, TheHeldKarpBoundLiesBetweenTheAssignmentAndTheBestTour) {
  for (int kind = 0; kind < kKinds; ++kind) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      const Matrix cost = random_costs(12, kind, seed);
      const double best = closed_cost(cost, exact_tour(cost));
      const Bound assignment = assignment_bound(cost), raised = held_karp_bound(cost, assignment, best, 2000);
      EXPECT_GE(raised.value, assignment.value);
      EXPECT_LE(raised.value, best + 1e-9);
      EXPECT_GE(raised.value, 0.93 * best) << "kind " << kind << ", seed " << seed;
    }
  }
}

TEST(TourAtsp, SearchFindsTheExactTourUpToThirteenNodes) {
  for (int n = 2; n <= 13; ++n) {
    for (int kind = 0; kind < kKinds; ++kind) {
      const Matrix cost = random_costs(n, kind, 3);
      AtspSearch subject = search(cost);
      subject.run_until(300000);
      ASSERT_TRUE(is_permutation_of(subject.best(), n));
      EXPECT_NEAR(subject.best_cost(), closed_cost(cost, exact_tour(cost)), 1e-9) << n << " nodes, kind " << kind;
    }
  }
}

TEST(TourAtsp, MoreStepsAreNeverWorseAndTheirDivisionDoesNotMatter) {
  const Matrix cost = random_costs(60, 3, 4);
  AtspSearch pieces = search(cost);
  double last = closed_cost(cost, pieces.best());
  for (std::int64_t steps = 0; steps <= 400000; steps += 20000) {
    pieces.run_until(steps);
    EXPECT_LE(pieces.best_cost(), last);
    last = pieces.best_cost();
  }
  AtspSearch whole = search(cost);
  whole.run_until(400000);
  EXPECT_EQ(whole.best(), pieces.best());
  EXPECT_EQ(whole.steps(), pieces.steps());
  AtspSearch other_seed = search(cost, 2);
  other_seed.run_until(400000);
  EXPECT_NE(other_seed.steps(), whole.steps()) << "the seed must matter";
}

/// Nodes on a ring, each 1 from the next; every other arc costs 2 to 5. The one best tour is the ring.
TEST(TourAtsp, SearchFindsAPlantedTourOfAHundredNodes) {
  constexpr int kNodes = 100;
  std::mt19937_64 random(5);
  std::vector<int> ring = counting(kNodes);
  std::shuffle(ring.begin(), ring.end(), random);
  Matrix cost(kNodes, kNodes);
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j < kNodes; ++j) cost(i, j) = 2 + static_cast<double>(random() % 4);
  }
  for (std::size_t i = 0; i < ring.size(); ++i) cost(ring[i], ring[(i + 1) % ring.size()]) = 1;
  AtspSearch subject = search(cost);
  subject.run_until(1000000);
  EXPECT_EQ(subject.best_cost(), kNodes);
  EXPECT_TRUE(subject.proven());
}

TEST(TourAtsp, ANumberPerColumnChangesCostsButNotTheTour) {
  const Matrix cost = random_costs(40, 2, 6);
  Matrix shifted = cost;
  for (int j = 0; j < 40; ++j) shifted.col(j).array() += 0.25 * (j % 7);
  const ClosedTour a = min_atsp(cost, {}), b = min_atsp(shifted, {});
  const double sum = 0.25 * (5 * 21 + 0 + 1 + 2 + 3 + 4);  // 40 = 5 rounds of 0..6, and 0..4
  EXPECT_NEAR(b.cost, a.cost + sum, 1e-9);
}

TEST(TourAtsp, BoundsOfClosedToursHoldAndAreCloseOnLargerProblems) {
  for (int kind = 0; kind < kKinds; ++kind) {
    SolverParams params;
    params.steps = 1e6;
    const ClosedTour tour = min_atsp(random_costs(50, kind, 7), params);
    EXPECT_LE(tour.bound, tour.cost);
    EXPECT_GE(tour.bound, 0.95 * tour.cost) << "kind " << kind;
  }
}

TEST(TourAtsp, InsertionKeepsTheOrderOfWhatWasThere) {
  const Matrix cost = random_costs(10, 3, 8);
  const std::vector<int> all = insert_missing(cost, {0, 5, 3, 9});
  ASSERT_TRUE(is_permutation_of(all, 10));
  std::vector<int> kept;
  for (const int node : all) {
    if (node == 0 || node == 5 || node == 3 || node == 9) kept.push_back(node);
  }
  EXPECT_EQ(kept, (std::vector<int>{0, 5, 3, 9}));
}

}  // namespace
}  // namespace arpent::tour
