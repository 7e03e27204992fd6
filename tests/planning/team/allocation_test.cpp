// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/allocation.h"

#include <gtest/gtest.h>

#include <set>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

Cluster cluster_at(int id, double x, double y, int elements = 20) {
  Cluster cluster;
  cluster.id = id;
  cluster.gain = 0.1;
  cluster.centre_m = {x, y};
  Viewpoint viewpoint{{x, y, 0.1 * id}, {}, 4};
  for (int i = 0; i < elements; ++i) viewpoint.elements.emplace_back(id, i, 0);
  cluster.elements = viewpoint.elements;
  cluster.viewpoints = {viewpoint};
  return cluster;
}

std::vector<Cluster> two_groups() {
  return {cluster_at(0, 1, 1), cluster_at(1, 1.2, 2), cluster_at(2, 1, 3),
          cluster_at(3, 7, 6), cluster_at(4, 6.8, 5), cluster_at(5, 7, 4)};
}

std::set<double> xs(const std::vector<Viewpoint>& tour) {
  std::set<double> xs;
  for (const Viewpoint& v : tour) xs.insert(v.pose.x_m);
  return xs;
}

TEST(Allocation, EachObjectiveGivesEveryClusterToOneRobotAndTheNearGroupToItsRobot) {
  const Ground ground = make_ground(FlatWorld{});
  for (const std::string objective : {"time", "tsga"}) {
    AllocationParams params;
    params.objective = objective;
    const auto tours = allocate(ground, two_groups(), {{{6, 6, 0}, 0}, {{2, 1, 0}, 0}}, params, {});
    ASSERT_EQ(tours.size(), 2U) << objective;
    EXPECT_EQ(tours[0].size(), 3U) << objective;
    EXPECT_EQ(tours[1].size(), 3U) << objective;
    for (const double x : xs(tours[0])) EXPECT_GT(x, 6) << objective;
    for (const double x : xs(tours[1])) EXPECT_LT(x, 2) << objective;
  }
}

TEST(Allocation, ByTimeARobotThatIsBusyGetsLess) {
  const Ground ground = make_ground(FlatWorld{});
  const auto tours = allocate(ground, two_groups(), {{{6, 6, 0}, 0}, {{2, 1, 0}, 120}}, {}, {});
  EXPECT_EQ(tours[0].size(), 6U);
  EXPECT_TRUE(tours[1].empty());
}

TEST(Allocation, NnbGivesOneClusterEachAndNoneTwice) {
  const Ground ground = make_ground(FlatWorld{});
  AllocationParams params;
  params.objective = "nnb";
  const auto tours = allocate(ground, {cluster_at(0, 4, 3)}, {{{4, 2, 0}, 0}, {{4, 4, 0}, 0}}, params, {});
  EXPECT_EQ(tours[0].size() + tours[1].size(), 1U);
}

TEST(Allocation, WhatNobodyHasAWayToIsStillGivenOutLast) {
  FlatWorld world;
  world.boxes.push_back({{4, 3.5}, {0.1, 3.5}, 0});  // a wall from side to side
  const Ground ground = make_ground(world);
  const auto tours =
      allocate(ground, {cluster_at(0, 6, 3), cluster_at(1, 2, 3)}, {{{1, 3, 0}, 0}, {{1, 5, 0}, 0}}, {}, {});
  std::size_t given = tours[0].size() + tours[1].size();
  EXPECT_EQ(given, 2U);
  for (const auto& tour : tours) {
    if (tour.size() == 2) {
      EXPECT_EQ(tour.back().pose.x_m, 6);
    }
  }
}

TEST(Allocation, NothingToDoGivesEmptyTours) {
  const auto tours = allocate(make_ground(FlatWorld{}), {}, {{{1, 1, 0}, 0}, {{2, 2, 0}, 0}}, {}, {});
  ASSERT_EQ(tours.size(), 2U);
  EXPECT_TRUE(tours[0].empty() && tours[1].empty());
}

}  // namespace
}  // namespace arpent::planning
