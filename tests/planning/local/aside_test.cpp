// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/aside.h"

#include <gtest/gtest.h>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

std::vector<Eigen::Vector2d> straight(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  std::vector<Eigen::Vector2d> way;
  for (int i = 0; i <= 100; ++i) way.push_back(a + 0.01 * i * (b - a));
  return way;
}

TEST(WayAside, EndsOffTheTeammatesWayAndOnFreeGround) {
  const Ground ground = make_ground(FlatWorld{});
  const auto way = straight({1, 3.5}, {7, 3.5});
  const auto leg = find_way_aside(ground, LegPlanner({}), {4, 3.5, 0.2}, way, 0.95);
  ASSERT_TRUE(leg);
  EXPECT_GE(std::abs(leg->goal.y_m - 3.5), 0.94);
  EXPECT_TRUE(ground.is_free(leg->goal));
  EXPECT_LT((leg->goal.position_m() - Eigen::Vector2d(4, 3.5)).norm(), 1.8) << "the nearest, not any";
  EXPECT_FALSE(first_contact(ground, leg->motions, leg->slack));
}

TEST(WayAside, WhoStandsClearStays) {
  const auto way = straight({1, 3.5}, {7, 3.5});
  EXPECT_FALSE(find_way_aside(make_ground(FlatWorld{}), LegPlanner({}), {4, 5, 0.2}, way, 0.95));
}

TEST(WayAside, ThereIsNoneInALaneThatTheTeammateFills) {
  FlatWorld lane;
  lane.size_m = {8, 1.4};
  const auto way = straight({0.5, 0.7}, {7.5, 0.7});
  EXPECT_FALSE(find_way_aside(make_ground(lane), LegPlanner({}), {4, 0.7, 0}, way, 0.95));
}

}  // namespace
}  // namespace arpent::planning
