// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/recovery.h"

#include <gtest/gtest.h>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

TEST(Recovery, TurnsAwayFromAWallItsNoseIsIn) {
  const Ground ground = make_ground({});
  const Pose2 nose_in{0.45, 3.5, 2.8};
  ASSERT_FALSE(ground.is_free(nose_in));
  const auto recovery = plan_recovery(ground, nose_in, Trail(3), {});
  ASSERT_TRUE(recovery);
  ASSERT_TRUE(recovery->turn);
  EXPECT_GE(ground.margin_m(end_of(*recovery->turn)), 0.02);
  EXPECT_LT(recovery->turn->turn_rad, 0) << "to the side where the nose leaves the wall";
}

TEST(Recovery, BacksOffAlongTheWayItCame) {
  // A dead end as wide as the robot, entered straight.
  FlatWorld world;
  world.boxes.push_back({{6, 3.5 - 0.35 - 0.5}, {1.5, 0.5}});
  world.boxes.push_back({{6, 3.5 + 0.35 + 0.5}, {1.5, 0.5}});
  world.boxes.push_back({{7, 3.5}, {0.5, 0.6}});
  const Ground ground = make_ground(world);
  Trail trail(4);
  for (double x = 2; x < 5.98; x += 0.01) trail.add({x, 3.5, 0});
  EXPECT_NEAR(trail.poses().front().x_m, 2, 0.1);
  const Pose2 stuck{5.98, 3.5, 0};
  ASSERT_FALSE(ground.is_free(stuck));
  RecoveryParams params;
  const auto recovery = plan_recovery(ground, stuck, trail, params);
  ASSERT_TRUE(recovery);
  EXPECT_FALSE(recovery->turn);
  ASSERT_FALSE(recovery->backwards.empty());
  EXPECT_NEAR(recovery->backwards.back().x_m, 5.98 - 1.5, 0.05) << "no room to turn: as far as it may";
  params.max_back_m = 4;
  const auto further = plan_recovery(ground, stuck, trail, params);
  ASSERT_TRUE(further);
  EXPECT_LT(further->backwards.back().x_m, 4.6) << "to where it can turn";
  EXPECT_GT(further->backwards.back().x_m, 3.5);
  double x = stuck.x_m;
  for (const Pose2& pose : further->backwards) {
    EXPECT_LE(pose.x_m, x + 1e-9);
    x = pose.x_m;
  }
  EXPECT_FALSE(plan_recovery(ground, stuck, Trail(4), params)) << "no way back is known";
}

TEST(Recovery, ATrailKeepsItsLastMetres) {
  Trail trail(1.0);
  for (int i = 0; i <= 300; ++i) trail.add({0.01 * i, 0, 0});
  EXPECT_NEAR(trail.poses().back().x_m, 3, 0.03);
  EXPECT_NEAR(trail.poses().front().x_m, 2, 0.07);
  trail.add({3, 0, 1});
  EXPECT_EQ(trail.poses().back().yaw_rad, 1);
}

}  // namespace
}  // namespace arpent::planning
