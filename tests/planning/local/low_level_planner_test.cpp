// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The state machine in a map that changes: a robot that jumps along its legs.
#include "planning/local/low_level_planner.h"

#include <gtest/gtest.h>

#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

using mapping::VoxelIndex;

/// The robot, its map and its planner. Blocks of the map are replaced when the world changes.
class Robot {
 public:
  explicit Robot(const FlatWorld& world, const LowLevelParams& params = {})
      : planner(params), map_(make_map(world, 0.1)), grid_({}) {
    see(world);
  }

  void see(const FlatWorld& world) {
    const mapping::TsdfMap next = make_map(world, 0.1);
    ++map_.storage().revision;
    for (const auto& block : next.storage().blocks) {
      mapping::Block& held = *map_.storage().by_index.at(block->index);
      if (held.distance_m == block->distance_m && held.weight == block->weight) continue;
      held.distance_m = block->distance_m;
      held.weight = block->weight;
      held.revision = map_.storage().revision;
    }
    grid_.update(map_);
    ground_.emplace(grid_, Footprint({}));
  }
  LowLevelOutput step(TrafficAdvice traffic = TrafficAdvice::kGo, double speed_mps = 0) {
    LowLevelOutput output = planner.step({*ground_, grid_, pose, traffic, speed_mps});
    if (output.order == DriveOrder::kFollow) {
      leg = output.leg;
      driven_m_ = 0;
    }
    if (output.order == DriveOrder::kStop) leg.reset();
    return output;
  }
  /// Moves on along the leg; turns take no time.
  void move(double by_m) {
    if (!leg) return;
    driven_m_ += by_m;
    double s = driven_m_;
    pose = leg->goal;
    for (const Motion& motion : leg->motions) {
      if (motion.is_turn()) continue;
      if (s <= motion.length_m) {
        pose = pose_at(motion, s / motion.length_m);
        return;
      }
      s -= motion.length_m;
    }
  }
  /// To target 7 at (6.5, 3.5), of which it has driven a metre.
  void set_out() {
    planner.set_tour({{{7, {6.5, 3.5, 0}}}, {}});
    EXPECT_EQ(step().order, DriveOrder::kFollow);
    move(1);
  }
  /// Steps and moves until the planner asks for a tour; the targets that were visited.
  std::vector<std::int64_t> run(ReplanReason& reason) {
    std::vector<std::int64_t> visited;
    for (int i = 0; i < 2000; ++i) {
      const LowLevelOutput output = step();
      if (output.visited) {
        visited.push_back(*output.visited);
        EXPECT_NE(output.order, DriveOrder::kFollow) << "there is something to look at first";
      }
      reason = output.replan;
      if (reason != ReplanReason::kNone) break;
      move(0.05);
    }
    return visited;
  }

  LowLevelPlanner planner;
  Pose2 pose{1.5, 3.5, 0};
  std::optional<Leg> leg;

 private:
  mapping::TsdfMap map_;
  GroundGrid grid_;
  std::optional<Ground> ground_;
  double driven_m_ = 0;
};

FlatWorld with_wall(double gap_m) {
  FlatWorld world;
  world.boxes.push_back({{4, (7 - gap_m) / 2}, {0.1, (7 - gap_m) / 2}});
  return world;
}

const Tour kTour{{{11, {3, 5.5, 1}}, {12, {6, 5.5, -1}}, {13, {6, 2, 3}}},
                 {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}, {4, 4, 4}, {5, 5, 5}}};

TEST(LowLevelPlanner, VisitsTheTargetsInOrderAndAsksForANewTour) {
  Robot robot({});
  EXPECT_EQ(robot.step().replan, ReplanReason::kNoTour);
  robot.planner.set_tour(kTour);
  ReplanReason reason = ReplanReason::kNone;
  EXPECT_EQ(robot.run(reason), (std::vector<std::int64_t>{11, 12, 13}));
  EXPECT_EQ(reason, ReplanReason::kTourDone);
  EXPECT_NEAR(robot.pose.x_m, 6, 0.1);
  EXPECT_NEAR(robot.pose.y_m, 2, 0.1);
  EXPECT_EQ(robot.step().replan, ReplanReason::kTourDone) << "until a tour comes";
}

TEST(LowLevelPlanner, AsksWhenEnoughOfItsOwnElementsAreComplete) {
  const std::vector<VoxelIndex> two_left = {{1, 1, 1}, {2, 2, 2}, {90, 90, 90}, {91, 90, 90}};
  const std::vector<VoxelIndex> one_left = {{5, 5, 5}, {90, 90, 90}, {91, 90, 90}, {92, 90, 90}, {93, 90, 90}};
  Robot robot({});
  robot.planner.set_tour(kTour);
  (void)robot.step();
  robot.planner.set_incomplete(two_left);
  EXPECT_DOUBLE_EQ(robot.planner.completed_share(), 0.6);
  EXPECT_EQ(robot.step().replan, ReplanReason::kNone);
  robot.planner.set_incomplete(one_left);
  EXPECT_DOUBLE_EQ(robot.planner.completed_share(), 0.8) << "new elements elsewhere do not count";
  const auto output = robot.step();
  EXPECT_EQ(output.replan, ReplanReason::kUtility);
  EXPECT_EQ(output.order, DriveOrder::kGoOn) << "it drives on while it waits";
  robot.planner.set_tour(kTour);
  EXPECT_EQ(robot.step().replan, ReplanReason::kNone);

  LowLevelParams thesis;
  thesis.judge_while_driving = false;
  Robot literal({}, thesis);
  literal.planner.set_tour(kTour);
  (void)literal.step();
  literal.planner.set_incomplete(one_left);
  ReplanReason reason = ReplanReason::kNone;
  EXPECT_EQ(literal.run(reason), (std::vector<std::int64_t>{11})) << "looked at between legs";
  EXPECT_EQ(reason, ReplanReason::kUtility);
}

TEST(LowLevelPlanner, GoesAroundAnObstacleThatAppearsAndKeepsTheTargetIfItCannot) {
  Robot robot({});
  robot.planner.set_tour({{{7, {6.5, 3.5, 0}}}, {}});
  ASSERT_EQ(robot.step().order, DriveOrder::kFollow);
  robot.move(0.5);
  FlatWorld world;
  world.boxes.push_back({{4.5, 3.5}, {0.3, 0.3}});
  robot.see(world);
  const auto around = robot.step();
  EXPECT_EQ(around.order, DriveOrder::kFollow);
  EXPECT_EQ(around.replan, ReplanReason::kNone);
  robot.move(0.3);
  robot.see(with_wall(0));
  const auto blocked = robot.step();
  EXPECT_EQ(blocked.order, DriveOrder::kStop);
  EXPECT_EQ(blocked.replan, ReplanReason::kObstacle);
  EXPECT_FALSE(blocked.visited);
  ASSERT_EQ(blocked.skipped.size(), 1U);
  EXPECT_EQ(blocked.skipped.front().reason, NoLeg::kNoWay);

  LowLevelParams thesis;
  thesis.bypass_obstacles = false;
  Robot literal({}, thesis);
  literal.planner.set_tour({{{7, {6.5, 3.5, 0}}}, {}});
  (void)literal.step();
  literal.see(world);
  EXPECT_EQ(literal.step().order, DriveOrder::kStop) << "Alg. 1 stops and waits for replanning";
  literal.see({});
  literal.planner.set_tour({{{7, {6.5, 3.5, 0}}}, {}});
  EXPECT_EQ(literal.step().order, DriveOrder::kFollow);
}

TEST(LowLevelPlanner, WhatLiesBehindTheRobotOrOffTheLegIsNoObstacle) {
  Robot robot({});
  robot.planner.set_tour({{{7, {6.5, 3.5, 0}}}, {}});
  for (int i = 0; i < 50; ++i) {
    (void)robot.step();
    robot.move(0.05);
  }
  FlatWorld world;
  world.boxes.push_back({{2.5, 3.5}, {0.2, 0.2}});
  world.boxes.push_back({{5, 5}, {0.3, 0.3}});
  robot.see(world);
  EXPECT_EQ(robot.step().order, DriveOrder::kGoOn);
}

TEST(LowLevelPlanner, RemembersUnreachableTargetsUntilTheMapChangesThere) {
  Robot robot(with_wall(0));
  const Tour tour{{{1, {6, 3, 0}}, {2, {2, 5.5, 0}}}, {}};
  robot.planner.set_tour(tour);
  const auto first = robot.step();
  ASSERT_EQ(first.skipped.size(), 1U);
  EXPECT_EQ(first.skipped.front().id, 1);
  EXPECT_EQ(first.order, DriveOrder::kFollow) << "to the next target";
  FlatWorld elsewhere = with_wall(0);
  elsewhere.boxes.push_back({{0.5, 0.5}, {0.2, 0.2}});  // on this side, far from the wall
  robot.see(elsewhere);
  ASSERT_EQ(robot.planner.unreachable().all().size(), 1U);
  robot.planner.set_tour({{{1, {6, 3, 0}}}, {}});
  EXPECT_EQ(robot.step().replan, ReplanReason::kNothingReachable);
  robot.see(with_wall(1.5));
  robot.planner.set_tour({{{1, {6, 3, 0}}}, {}});
  EXPECT_EQ(robot.step().order, DriveOrder::kFollow) << "the wall has a gap now";
}

TEST(LowLevelPlanner, YieldsAndLooksForItsWayAgain) {
  Robot robot({});
  robot.set_out();
  EXPECT_EQ(robot.step(TrafficAdvice::kYield).order, DriveOrder::kStop);
  EXPECT_EQ(robot.step(TrafficAdvice::kYield).order, DriveOrder::kGoOn) << "said once";
  const auto on = robot.step();
  EXPECT_EQ(on.order, DriveOrder::kFollow);
  EXPECT_EQ(on.leg->start, robot.pose);
  EXPECT_EQ(on.replan, ReplanReason::kNone);
}

TEST(LowLevelPlanner, ALegGoesOnUnderANewTourWithTheSameFirstTarget) {
  Robot robot({});
  robot.set_out();
  robot.planner.set_tour({{{99, {6.5, 3.5, 0}}, {98, {6, 1, 0}}}, {}});
  EXPECT_EQ(robot.step().order, DriveOrder::kGoOn);
  EXPECT_EQ(robot.planner.target()->id, 99);
  robot.planner.set_tour({{{98, {6, 1, 0}}}, {}});
  EXPECT_EQ(robot.step().order, DriveOrder::kFollow);
  robot.planner.set_tour({});
  const auto none = robot.step();
  EXPECT_EQ(none.order, DriveOrder::kStop);
  EXPECT_EQ(none.replan, ReplanReason::kNoTour);
}

TEST(LowLevelPlanner, ARobotThatDrivesStopsBeforeALegThatBeginsWithATurn) {
  constexpr double kMps = 0.5;
  Robot robot({});
  robot.set_out();
  robot.planner.set_tour({{{8, {6, 4, 0}}}, {}});
  EXPECT_EQ(robot.step(TrafficAdvice::kGo, kMps).order, DriveOrder::kFollow) << "an arc from where it drives";
  robot.planner.set_tour({{{9, {1, 3.5, 3}}}, {}});
  EXPECT_EQ(robot.step(TrafficAdvice::kGo, kMps).order, DriveOrder::kStop);
  EXPECT_FALSE(robot.planner.target());
  robot.pose.x_m += 0.2;
  EXPECT_EQ(robot.step(TrafficAdvice::kGo, 0.5 * kMps).order, DriveOrder::kGoOn) << "said once";
  robot.pose.x_m += 0.05;
  const auto back = robot.step();
  ASSERT_EQ(back.order, DriveOrder::kFollow);
  EXPECT_TRUE(back.leg->motions.front().is_turn());
  EXPECT_EQ(back.leg->start, robot.pose) << "where it stands, not where it was told to stop";
  EXPECT_EQ(back.replan, ReplanReason::kNone);
}

TEST(LowLevelPlanner, ARobotThatDrivesStopsBeforeALegShorterThanItsBrakingDistance) {
  const double braking_m = 0.5 * 0.5 / (2 * LowLevelParams().deceleration_mps2);
  Robot robot({});
  robot.set_out();
  const Pose2 at = robot.pose;
  const auto ahead = [&](double by_m) { return Pose2{at.x_m + by_m, at.y_m, 0}; };
  robot.planner.set_tour({{{8, ahead(braking_m - 0.05)}}, {}});
  EXPECT_EQ(robot.step(TrafficAdvice::kGo, 0.5).order, DriveOrder::kStop);
  EXPECT_EQ(robot.step(TrafficAdvice::kGo, 0.3).order, DriveOrder::kFollow) << "slower, it can stop in time";
  robot.planner.set_tour({{{9, ahead(braking_m + 0.15)}}, {}});
  EXPECT_EQ(robot.step(TrafficAdvice::kGo, 0.5).order, DriveOrder::kFollow);
}

TEST(LowLevelPlanner, ALegThatWasBrokenOffBeginsAnewWhereTheRobotStands) {
  Robot robot({});
  robot.set_out();
  robot.planner.break_off();
  const auto on = robot.step();
  ASSERT_EQ(on.order, DriveOrder::kFollow);
  EXPECT_EQ(on.leg->start, robot.pose);
  EXPECT_EQ(robot.planner.target()->id, 7);
}

TEST(LowLevelPlanner, ARobotThatLostItsLegGetsANewOne) {
  Robot robot({});
  robot.planner.set_tour({{{7, {6.5, 3.5, 0}}}, {}});
  (void)robot.step();
  robot.pose.y_m += 0.45;
  EXPECT_EQ(robot.step().order, DriveOrder::kGoOn);
  robot.pose.y_m += 0.15;
  EXPECT_EQ(robot.step().order, DriveOrder::kFollow);
}

TEST(LegProgress, NeverGoesBackAndCountsTurns) {
  const Pose2 start{1, 1, 0};
  Leg leg{start, {}, {}, {}};
  leg.motions = {drive(start, 1, 0)};
  leg.motions.push_back(turn_to(end_of(leg.motions.back()), 1.5));
  leg.motions.push_back(drive(end_of(leg.motions.back()), 1, 0));
  LegProgress progress(leg);
  progress.advance({1.52, 1.1, 0});
  EXPECT_NEAR(progress.place().driven_m, 0.5, 0.03);
  EXPECT_NEAR(progress.off_m(), 0.1, 0.02);
  progress.advance({1.2, 1, 0});
  EXPECT_NEAR(progress.place().driven_m, 0.5, 0.03);
  progress.advance({2, 1, 0.7});
  EXPECT_EQ(progress.place().motion, 1U);
  EXPECT_NEAR(progress.place().share, 0.7 / 1.5, 0.05);
  progress.advance({2, 1.5, 1.5});
  EXPECT_EQ(progress.place().motion, 2U);
}

}  // namespace
}  // namespace arpent::planning
