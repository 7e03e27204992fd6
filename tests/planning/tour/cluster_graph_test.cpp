// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/cluster_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/error.h"
#include "planning/tour/three_opt.h"
#include "tests/planning/tour/problems.h"

namespace arpent::tour {
namespace {

/// Viewpoints on a line; their numbers are their places [m].
double on_a_line(int from, int to) {
  return std::abs(from - to);
}

/// Robot at 0; U = {4, 2, 3}, gain 0.75; V = {10, 12}, gain 0.25.
/// From the start: U is entered at 2, then 3, 4: inter 2 m, intra 2 m. V at 10: inter 10 m, intra 2 m.
/// U to V: nearest pair (4, 10), inter 6 m. V to U: (10, 4), inter 6 m, intra 4, 3, 2: 2 m.
TEST(TourClusterGraph, UtilitiesAreThoseOfEquation23ByHand) {
  const ClusterGraph graph({{{4, 2, 3}, 0.75}, {{10, 12}, 0.25}}, {0}, on_a_line);
  const Arcs f = graph.utilities(0.5, 0.1);
  EXPECT_NEAR(f.from_start(0, 0), 0.75 * std::exp(-0.5 * 2 - 0.1 * 2), 1e-15);
  EXPECT_NEAR(f.from_start(0, 1), 0.25 * std::exp(-0.5 * 10 - 0.1 * 2), 1e-15);
  EXPECT_NEAR(f.among(0, 1), 0.25 * std::exp(-0.5 * 6 - 0.1 * 2), 1e-15);
  EXPECT_NEAR(f.among(1, 0), 0.75 * std::exp(-0.5 * 6 - 0.1 * 2), 1e-15);
  const Arcs t = graph.durations_s(0.5);
  EXPECT_NEAR(t.from_start(0, 0), 8, 1e-12);
  EXPECT_NEAR(t.among(0, 1), 16, 1e-12);
  EXPECT_EQ(graph.viewpoints(0, {0, 1}), (std::vector<int>{2, 3, 4, 10, 12}));
  EXPECT_EQ(graph.viewpoints(0, {1, 0}), (std::vector<int>{10, 12, 4, 3, 2}));
}

TEST(TourClusterGraph, WhereThereIsNoWayUtilityIsZeroAndTimeInfinite) {
  const ClusterGraph graph({{{1}, 0.5}, {{100}, 0.5}}, {0}, [](int from, int to) {
    return (from < 50) == (to < 50) ? on_a_line(from, to) : std::numeric_limits<double>::infinity();
  });
  EXPECT_EQ(graph.utilities(0.5, 0.1).from_start(0, 1), 0);
  EXPECT_TRUE(std::isinf(graph.durations_s(0.5).from_start(0, 1)));
}

TEST(TourClusterGraph, ImpossibleInputIsRefused) {
  EXPECT_THROW(ClusterGraph({{{}, 0.5}}, {0}, on_a_line), InputError);
  EXPECT_THROW(ClusterGraph({{{1}, -0.5}}, {0}, on_a_line), InputError);
  EXPECT_THROW(ClusterGraph({{{1}, 0.5}}, {0}, [](int, int) { return std::nan(""); }), InputError);
}

TEST(TourThreeOpt, IsNeverLongerThanItsInputAndKeepsTheEntry) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    for (const int kind : {0, 3}) {
      const Matrix length = random_costs(12, kind, seed);
      std::vector<int> path = counting(12);
      std::mt19937_64 random(seed);
      std::shuffle(path.begin() + 1, path.end(), random);
      const std::vector<int> better = three_opt(length, path);
      EXPECT_TRUE(is_permutation_of(better, 12));
      EXPECT_EQ(better.front(), path.front());
      EXPECT_LE(path_length(length, better), path_length(length, path));
      EXPECT_EQ(three_opt(length, better), better) << "it stopped before it was done";
    }
  }
}

TEST(TourThreeOpt, IsCloseToBruteForceInThePlane) {
  double found = 0, best = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Matrix length = random_costs(7, 3, seed);
    length = (0.5 * (length + length.transpose())).eval();
    found += path_length(length, intra_cluster_path(length, 2));
    best += least_over_permutations(
        7, [&](const auto& path) { return path.front() == 2 ? path_length(length, path) : 1e9; });
  }
  EXPECT_GE(found, best - 1e-9);
  EXPECT_LE(found, 1.01 * best);
}

}  // namespace
}  // namespace arpent::tour
