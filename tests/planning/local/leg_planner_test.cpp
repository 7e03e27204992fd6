// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Legs in worlds by formula. Validity is checked against the formula, not against the grid that the planner saw.
#include "planning/local/leg_planner.h"

#include <gtest/gtest.h>

#include "control/path.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

const FootprintParams kFootprint;
constexpr double kGridErrorM = 0.012;  ///< what Ground::clearance_m promises for cells of 5 cm

LegPlanner make_planner(const std::string& name) {
  LegPlannerParams params;
  params.planner = name;
  return LegPlanner(params);
}

/// The whole leg, densely sampled, against the world; and that it joins its ends.
void expect_sound(const Leg& leg, const FlatWorld& world, double radius = 0.5) {
  Pose2 at = leg.start;
  for (const Motion& motion : leg.motions) {
    ASSERT_LT((motion.start.position_m() - at.position_m()).norm(), 1e-5);
    ASSERT_LT(std::abs(wrap_angle(motion.start.yaw_rad - at.yaw_rad)), 1e-5);
    EXPECT_LE(std::abs(motion.curvature_1pm), 1 / radius + 1e-9);
    EXPECT_GE(motion.length_m, 0) << "forwards only";
    const int steps = 2 + static_cast<int>(100 * (motion.length_m + std::abs(motion.turn_rad)));
    for (int i = 0; i <= steps; ++i) {
      const Pose2 pose = pose_at(motion, static_cast<double>(i) / steps);
      // Half of a look's least step may lie between two looks.
      ASSERT_LE(intrusion_m(world, kFootprint, pose), kGridErrorM + 0.01) << pose.x_m << ", " << pose.y_m;
    }
    at = end_of(motion);
  }
  EXPECT_LT((leg.goal.position_m() - at.position_m()).norm(), 1e-5);
  EXPECT_LT(std::abs(wrap_angle(leg.goal.yaw_rad - at.yaw_rad)), 1e-5);
}

double turned_rad(const Motions& motions) {
  double sum = 0;
  for (const Motion& motion : motions) sum += std::abs(motion.turn_rad);
  return sum;
}

TEST(LegPlanner, InTheOpenALegIsAsShortAsItsArcsAllow) {
  const FlatWorld world{{20, 20}, {}};
  const Ground ground = make_ground(world);
  const LegPlanner planner({});
  std::mt19937 random(1);
  for (int i = 0; i < 40; ++i) {
    const Pose2 start{uniform(random, 4, 16), uniform(random, 4, 16), uniform(random, -3, 3)};
    const Pose2 goal{uniform(random, 4, 16), uniform(random, 4, 16), uniform(random, -3, 3)};
    const LegResult result = planner.plan(ground, start, goal);
    ASSERT_TRUE(result.leg) << to_text(result.reason);
    expect_sound(*result.leg, world);
    const double straight = (goal.position_m() - start.position_m()).norm();
    // Two turns of at most half a circle, each worth half a metre per radian and a stop, bound what arcs may cost.
    EXPECT_LE(ground.cost_of(result.leg->motions), straight + 2 * (0.5 + 0.5 * std::numbers::pi) + 1e-6);
    EXPECT_LE(length_of(result.leg->motions), 1.02 * straight + 3.2);
  }
  // Straight ahead it is straight.
  const auto ahead = planner.plan(ground, {5, 5, 0.3}, {5 + 8 * std::cos(0.3), 5 + 8 * std::sin(0.3), 0.3});
  ASSERT_TRUE(ahead.leg);
  EXPECT_NEAR(length_of(ahead.leg->motions), 8, 1e-6);
  EXPECT_EQ(turned_rad(ahead.leg->motions), 0);
}

TEST(LegPlanner, AroundABoxItIsLittleLongerThanTheTautString) {
  FlatWorld world{{12, 10}, {{{6, 5}, {1, 1}}}};
  const Ground ground = make_ground(world);
  const auto result = LegPlanner({}).plan(ground, {2, 5, 0}, {10, 5, 0});
  ASSERT_TRUE(result.leg);
  expect_sound(*result.leg, world);
  // A string around the box at the short axis' distance: two tangents to circles about its corners, two arcs, one side.
  const double r = 0.25, dx = 3, dy = 1, d = std::hypot(dx, dy);
  const double tangent = std::sqrt(d * d - r * r);
  const double arc = std::atan2(dy, dx) + std::asin(r / d);
  const double taut = 2 * (tangent + r * arc) + 2;
  EXPECT_GT(length_of(result.leg->motions), taut);
  EXPECT_LT(length_of(result.leg->motions), 1.06 * taut);
  EXPECT_EQ(turned_rad(result.leg->motions), 0) << "no stop where arcs do";
  // Room costs little: it keeps off the box.
  const Pose2 middle = pose_at(result.leg->motions[result.leg->motions.size() / 2], 0.5);
  EXPECT_GT(world.distance_m(middle.position_m()), 0.4);
}

FlatWorld rooms_with_door(double width_m) {
  FlatWorld world;
  const double side = (7 - width_m) / 2;
  world.boxes.push_back({{4, side / 2}, {0.1, side / 2}});
  world.boxes.push_back({{4, 7 - side / 2}, {0.1, side / 2}});
  return world;
}

TEST(LegPlanner, DoorsOfSeventyAndNinetyCentimetresArePassed) {
  for (const double width : {0.7, 0.9}) {
    for (const double angle : {0.0, 0.31}) {  // against the cells too
      FlatWorld world = rooms_with_door(width);
      const LegPlanner planner({});
      for (const Pose2& start : {Pose2{1.5, 3.5, 0}, Pose2{1, 1, 1.5}, Pose2{3.2, 6, -1.57}}) {
        const auto result = planner.plan(make_ground(world), start, {6.5, 2, angle});
        ASSERT_TRUE(result.leg) << width << " m: " << to_text(result.reason);
        expect_sound(*result.leg, world);
      }
    }
  }
}

TEST(LegPlanner, WhatCannotBeReachedIsSaidWithItsReason) {
  const LegPlanner planner({});
  const Ground closed = make_ground(rooms_with_door(0.3));
  const Pose2 here{1.5, 3.5, 0}, there{6.5, 3.5, 0};
  const auto reason = [&](const Ground& ground, const Pose2& start, const Pose2& goal) {
    const LegResult result = planner.plan(ground, start, goal);
    EXPECT_FALSE(result.leg);
    return result.reason;
  };
  EXPECT_EQ(reason(closed, here, there), NoLeg::kNoWay);
  const Ground ground = make_ground(rooms_with_door(0.9));
  EXPECT_EQ(reason(ground, {3.9, 1, 0}, there), NoLeg::kStartBlocked);
  EXPECT_EQ(reason(ground, {-5, 1, 0}, there), NoLeg::kStartUnknown);
  EXPECT_EQ(reason(ground, here, {4.1, 1, 0}), NoLeg::kGoalBlocked);
  EXPECT_EQ(reason(ground, here, {6.5, 30, 0}), NoLeg::kGoalUnknown);
  // In a corridor as wide as the robot nothing can turn about.
  FlatWorld corridor{{8, 0.7}, {}};
  EXPECT_EQ(reason(make_ground(corridor), {2, 0.35, 0}, {6, 0.35, std::numbers::pi}), NoLeg::kTooTight);
  EXPECT_TRUE(planner.plan(make_ground(corridor), {2, 0.35, 0}, {6, 0.35, 0}).leg);
  LegPlannerParams hasty;
  hasty.lattice.max_expansions = 1;
  EXPECT_EQ(LegPlanner(hasty).plan(ground, {1, 1, 1.5}, {6.5, 6, 0}).reason, NoLeg::kBudget);
}

TEST(LegPlanner, ATouchAtTheStartIsForgivenThereOnly) {
  FlatWorld world;
  const Ground ground = make_ground(world);
  const Pose2 grazing{2, 0.25, 0.0};
  ASSERT_FALSE(ground.is_free(grazing));
  const auto result = LegPlanner({}).plan(ground, grazing, {6, 3, 0});
  ASSERT_TRUE(result.leg);
  EXPECT_FALSE(LegPlanner({}).plan(ground, {6, 3, 0}, grazing).leg);
  for (const Motion& motion : result.leg->motions) {
    for (int i = 0; i <= 50; ++i) EXPECT_LE(intrusion_m(world, kFootprint, pose_at(motion, i / 50.0)), 0.08);
  }
}

class EitherPlanner : public testing::TestWithParam<const char*> {};

TEST_P(EitherPlanner, EveryLegInRandomWorldsIsFreeAndForwards) {
  const LegPlanner planner = make_planner(GetParam());
  std::mt19937 random(7);
  const int worlds = std::string(GetParam()) == "lattice" ? 36 : 8;
  int found = 0, asked = 0, lost = 0;
  for (int trial = 0; trial < worlds; ++trial) {
    const FlatWorld world = random_world(random, 7);
    const Ground ground = make_ground(world);
    for (int query = 0; query < 3; ++query) {
      const Pose2 start{uniform(random, 0.3, 7.7), uniform(random, 0.3, 6.7), uniform(random, -3, 3)};
      const Pose2 goal{uniform(random, 0.3, 7.7), uniform(random, 0.3, 6.7), uniform(random, -3, 3)};
      if (!ground.is_free(start) || !ground.is_free(goal)) continue;
      ++asked;
      const LegResult result = planner.plan(ground, start, goal);
      if (!result.leg) {
        lost += result.reason == NoLeg::kBudget ? 1 : 0;
        continue;
      }
      ++found;
      expect_sound(*result.leg, world);
      for (const DrivePiece& piece : pieces_of(*result.leg)) {
        const control::Path path(piece.points_m, {});
        for (double s = 0.1; s < path.length_m() - 0.1; s += 0.02) {
          EXPECT_LT(std::abs(path.at(s).curvature_1pm), 2.2);
        }
      }
    }
  }
  EXPECT_GT(asked, worlds / 2);
  EXPECT_GT(found, asked * 6 / 10);
  EXPECT_LE(lost, std::string(GetParam()) == "lattice" ? 1 + asked / 50 : asked / 4) << "for want of steps";
}

/// Whether all voxels of the band under the ellipse were known.
bool stands_on_known(const mapping::TsdfMap& map, const Pose2& pose) {
  const int last = static_cast<int>(std::floor(0.6 / map.params().voxel_m - 0.5 + 1e-9));
  for (int i = 0; i < 64; ++i) {
    const double t = 2 * std::numbers::pi * i / 32, share = i < 32 ? 0.95 : 0.5;
    const Eigen::Vector2d rim(kFootprint.semi_axis_long_m * std::cos(t), kFootprint.semi_axis_short_m * std::sin(t));
    const Eigen::Vector2d p = pose.position_m() + share * (Eigen::Rotation2Dd(pose.yaw_rad) * rim);
    for (int layer = 1; layer <= last; ++layer) {
      if (!map.is_known(map.index_of({p.x(), p.y(), (layer + 0.5) * map.params().voxel_m}))) return false;
    }
  }
  return true;
}

TEST_P(EitherPlanner, LegsFromCoarseMapsWithHolesStayOnKnownFreeGround) {
  const LegPlanner planner = make_planner(GetParam());
  std::mt19937 random(17);
  int found = 0;
  for (int trial = 0; trial < 6; ++trial) {
    const FlatWorld world = random_world(random, 4);
    mapping::TsdfMap map = make_map(world, trial % 2 == 0 ? 0.2 : 0.1);
    for (auto& block : map.storage().blocks) {
      for (int hole = 0; hole < 2; ++hole) block->weight[random() % mapping::kBlockVoxels] = 0.1F;
    }
    GroundGrid grid({});
    grid.update(map);
    const Ground ground(grid, Footprint(kFootprint));
    for (int query = 0; query < 20; ++query) {
      const Pose2 start{uniform(random, 0.3, 7.7), uniform(random, 0.3, 6.7), uniform(random, -3, 3)};
      const Pose2 goal{uniform(random, 0.3, 7.7), uniform(random, 0.3, 6.7), uniform(random, -3, 3)};
      if (!ground.is_free(start) || !ground.is_free(goal)) continue;
      const LegResult result = planner.plan(ground, start, goal);
      if (!result.leg) continue;
      ++found;
      for (const Motion& motion : result.leg->motions) {
        for (int i = 0; i <= 40; ++i) {
          const Pose2 pose = pose_at(motion, i / 40.0);
          // Interpolation between coarse voxels rounds the corners of boxes.
          EXPECT_LE(intrusion_m(world, kFootprint, pose), 0.03 + 0.25 * map.params().voxel_m);
          EXPECT_TRUE(stands_on_known(map, pose)) << pose.x_m << ", " << pose.y_m;
        }
      }
    }
  }
  EXPECT_GT(found, 3);
}

TEST_P(EitherPlanner, TheSameQuestionHasTheSameAnswerWhateverWasAskedBefore) {
  std::mt19937 random(3);
  const FlatWorld world = random_world(random, 4);
  const Ground ground = make_ground(world);
  const LegPlanner one = make_planner(GetParam()), other = make_planner(GetParam());
  const Pose2 start{0.8, 0.8, 0}, goal{7, 6, 1};
  const auto first = one.plan(ground, start, goal);
  ASSERT_TRUE(first.leg) << to_text(first.reason);
  (void)other.plan(ground, goal, start);
  (void)other.plan(ground, {4, 6, 0}, start);
  const auto second = other.plan(ground, start, goal);
  ASSERT_TRUE(second.leg);
  ASSERT_EQ(first.leg->motions.size(), second.leg->motions.size());
  for (std::size_t i = 0; i < first.leg->motions.size(); ++i) {
    const Motion &a = first.leg->motions[i], &b = second.leg->motions[i];
    EXPECT_TRUE(a.start == b.start && a.length_m == b.length_m && a.curvature_1pm == b.curvature_1pm &&
                a.turn_rad == b.turn_rad);
  }
}

TEST_P(EitherPlanner, ANewWallForbidsTheOldWayAndItsRemovalRestoresIt) {
  const LegPlanner planner = make_planner(GetParam());
  FlatWorld before{{8, 7}, {{{4, 2.2}, {0.1, 2.2}}}};
  FlatWorld walled = before;
  walled.boxes.push_back({{4, 5.7}, {0.1, 1.3}});
  const Pose2 start{2, 3.5, 0}, goal{6, 3.5, 0};
  const auto first = planner.plan(make_ground(before), start, goal);
  ASSERT_TRUE(first.leg) << to_text(first.reason);
  EXPECT_TRUE(first_contact(make_ground(walled), first.leg->motions));
  EXPECT_FALSE(planner.plan(make_ground(walled), start, goal).leg);
  const auto again = planner.plan(make_ground(before), start, goal);
  ASSERT_TRUE(again.leg);
  EXPECT_DOUBLE_EQ(length_of(again.leg->motions), length_of(first.leg->motions));
}

INSTANTIATE_TEST_SUITE_P(Planners, EitherPlanner, testing::Values("lattice", "lazy_prm"));

TEST(Leg, PiecesAreSplitAtTurnsOnTheSpotAndEndInTheirHeadings) {
  const Pose2 start{1, 1, 0};
  Leg leg{start, {}, {}, {}};
  leg.motions = {turn_to(start, 0.5)};
  leg.motions.push_back(drive(end_of(leg.motions.back()), 1, 0));
  leg.motions.push_back(drive(end_of(leg.motions.back()), 1, 1));
  leg.motions.push_back(turn_to(end_of(leg.motions.back()), -1));
  leg.motions.push_back(drive(end_of(leg.motions.back()), 1, 0));
  leg.goal = end_of(leg.motions.back());
  const auto pieces = pieces_of(leg);
  ASSERT_EQ(pieces.size(), 2U);
  EXPECT_EQ(pieces[0].points_m.front(), start.position_m());
  EXPECT_EQ(pieces[0].points_m.back(), pieces[1].points_m.front());
  EXPECT_DOUBLE_EQ(pieces[0].end_heading_rad, -1);
  EXPECT_DOUBLE_EQ(pieces[1].end_heading_rad, -1);
  EXPECT_NEAR(control::Path(pieces[0].points_m, {}).length_m(), 2, 1e-3);

  const Leg turn{start, {1, 1, 2}, {turn_to(start, 2)}, {}};
  const auto creep = pieces_of(turn);
  ASSERT_EQ(creep.size(), 1U);
  EXPECT_NEAR(control::Path(creep[0].points_m, {}).length_m(), kCreepM, 1e-9);
  EXPECT_DOUBLE_EQ(creep[0].end_heading_rad, 2);
  EXPECT_TRUE(pieces_of({start, start, {}, {}}).empty());
}

}  // namespace
}  // namespace arpent::planning
