// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/team.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/planning/tour/problems.h"

namespace arpent::tour {
namespace {

/// Two robots at 0 and 10 on a line, clusters of gain 1 at 2 (a), 4 (b) and 7 (c), f = 2^-distance, in ascending
/// distance to a robot: a (2 from robot 0), c (3 from robot 1), b (4 from robot 0).
///   a: robot 0 gains 2^-2 = 0.25, robot 1 2^-8: robot 0.
///   c: robot 0: path a c gains 2^-5; robot 1 gains 2^-3: robot 1.
///   b: robot 0: a b gains 2^-2 = 0.25; robot 1: c b gains 2^-3: robot 0.
TEST(TourTsga, FollowsAlgorithm2ByHand) {
  const std::vector<double> place = {2, 4, 7}, robot = {0, 10};
  Arcs f{Matrix(3, 3), Matrix(2, 3)};
  Matrix distance_m(2, 3);
  for (int v = 0; v < 3; ++v) {
    for (int u = 0; u < 3; ++u)
      f.among(u, v) = std::exp2(-std::abs(place[static_cast<std::size_t>(u)] - place[static_cast<std::size_t>(v)]));
    for (int i = 0; i < 2; ++i) {
      distance_m(i, v) = std::abs(place[static_cast<std::size_t>(v)] - robot[static_cast<std::size_t>(i)]);
      f.from_start(i, v) = std::exp2(-distance_m(i, v));
    }
  }
  const std::vector<OpenTour> tours = tsga(f, distance_m, {});
  ASSERT_EQ(tours.size(), 2U);
  EXPECT_EQ(tours[0].order, (std::vector<int>{0, 1}));
  EXPECT_NEAR(tours[0].value, 0.5, 1e-12);
  EXPECT_EQ(tours[1].order, (std::vector<int>{2}));
  EXPECT_NEAR(tours[1].value, 0.125, 1e-12);
}

TEST(TourTsga, OneRobotGetsItsMaxAtsp) {
  const Matrix among = random_costs(11, 0, 1);
  const Arcs utility{among, among.topRows(1)};
  const std::vector<OpenTour> tours = tsga(utility, among.topRows(1), {});
  EXPECT_NEAR(tours[0].value, max_atsp(first_row(among), among, {}).value, 1e-12);
}

TEST(TourTsga, EveryClusterGoesToOneRobotAndTheSameInputGivesTheSameTours) {
  const Matrix among = random_costs(30, 3, 2);
  const Arcs utility{(-3 * among).array().exp().matrix(), (-3 * among.topRows(3)).array().exp().matrix()};
  const std::vector<OpenTour> tours = tsga(utility, among.topRows(3), {}), again = tsga(utility, among.topRows(3), {});
  std::vector<int> all;
  for (std::size_t r = 0; r < 3; ++r) {
    all.insert(all.end(), tours[r].order.begin(), tours[r].order.end());
    EXPECT_EQ(tours[r].order, again[r].order);
    EXPECT_GE(tours[r].bound, tours[r].value);
  }
  EXPECT_TRUE(is_permutation_of(all, 30));
}

TEST(TourTsga, RobotsWithoutClustersGetEmptyTours) {
  const std::vector<OpenTour> tours = tsga({Matrix(0, 0), Matrix(2, 0)}, Matrix(2, 0), {});
  ASSERT_EQ(tours.size(), 2U);
  EXPECT_TRUE(tours[0].order.empty() && tours[1].order.empty());
}

TEST(TourNearestNeighbours, PickInTurnAndShareOnlyWhenAsked) {
  Matrix from_start(3, 2);
  from_start << 1, 2,  //
      3, 4,            //
      5, 6;
  EXPECT_EQ(nearest_neighbour_picks(from_start, false), (std::vector<int>{1, 0, -1}));
  EXPECT_EQ(nearest_neighbour_picks(from_start, true), (std::vector<int>{1, 1, 1}));
}

}  // namespace
}  // namespace arpent::tour
