// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Legs as the path tracker drives them, with the lag and the delay of a base.
#include <gtest/gtest.h>

#include "control/path_tracker.h"
#include "planning/local/leg_planner.h"
#include "tests/control/plant.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

using control::TrackerMode;

constexpr double kPeriodS = 0.05;

struct Drive {
  Pose2 end;
  bool arrived = true;
  double deepest_m = -1e9;  ///< into obstacles
};

/// Piece after piece; the pose is the true one.
Drive drive_leg(const FlatWorld& world, const Leg& leg) {
  control::PathTracker tracker({});
  control::Plant plant({}, {from_utime(1000000), leg.start.position_m(), leg.start.yaw_rad, {}});
  Drive drive;
  for (const DrivePiece& piece : pieces_of(leg)) {
    tracker.follow(control::Path(piece.points_m, {}), piece.end_heading_rad);
    bool arrived = false;
    for (int i = 0; i < 2000 && !arrived; ++i) {
      const auto output = tracker.step(plant.state().stamp, plant.state());
      EXPECT_NE(output.mode, TrackerMode::kBrake) << output.reason;
      arrived = output.mode == TrackerMode::kArrived;
      plant.move(output.command, kPeriodS);
      const auto& state = plant.state();
      drive.deepest_m =
          std::max(drive.deepest_m, intrusion_m(world, {}, {state.p_map_m.x(), state.p_map_m.y(), state.yaw_rad}));
    }
    drive.arrived = drive.arrived && arrived;
  }
  const auto& state = plant.state();
  drive.end = {state.p_map_m.x(), state.p_map_m.y(), wrap_angle(state.yaw_rad)};
  return drive;
}

TEST(DrivenLeg, TheTrackerDrivesLegsToTheirGoalsWithoutTouchingAnything) {
  std::mt19937 random(23);
  const LegPlanner planner({});
  int driven = 0;
  while (driven < 12) {
    const FlatWorld world = random_world(random, 5);
    const Ground ground = make_ground(world);
    const Pose2 start{uniform(random, 0.5, 7.5), uniform(random, 0.5, 6.5), uniform(random, -3, 3)};
    const Pose2 goal{uniform(random, 0.5, 7.5), uniform(random, 0.5, 6.5), uniform(random, -3, 3)};
    const auto result = planner.plan(ground, start, goal);
    if (!result.leg) continue;
    ++driven;
    const Drive drive = drive_leg(world, *result.leg);
    EXPECT_TRUE(drive.arrived);
    EXPECT_LT((drive.end.position_m() - goal.position_m()).norm(), 0.1) << "within GoalReached's tolerance";
    EXPECT_LT(std::abs(wrap_angle(drive.end.yaw_rad - goal.yaw_rad)), 0.1);
    EXPECT_LT(drive.deepest_m, 0.03) << "what the tracker strays from its path";
  }
}

TEST(DrivenLeg, ATurnOnTheSpotIsDrivenToo) {
  const FlatWorld world;
  const auto result = LegPlanner({}).plan(make_ground(world), {4, 3.5, 0}, {4, 3.5, 2.5});
  ASSERT_TRUE(result.leg);
  const Drive drive = drive_leg(world, *result.leg);
  EXPECT_TRUE(drive.arrived);
  EXPECT_NEAR(drive.end.yaw_rad, 2.5, 0.1);
  EXPECT_LT((drive.end.position_m() - Eigen::Vector2d(4, 3.5)).norm(), 0.1);
}

}  // namespace
}  // namespace arpent::planning
