// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// An explorer that is led: it knows its room from a teammate's patches alone, goes where it is sent, and stands when
// teammates are in its way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mapping/exchange/patch_builder.h"
#include "planning/mission/explorer.h"

namespace arpent::planning {
namespace {

using Kind = ExplorerOrder::Kind;
constexpr double kLength = 7.0, kWidth = 3.0, kHeight = 1.8;
const PinholeCamera kCamera{160, 128, 94.25, 94.25, 79.5, 63.5};

Pose T_body_cam() {
  Pose T = Pose::Identity();
  T.linear() = R_body_from_camera_axes();
  T.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return T;
}

stereo::DepthMap render(const Pose& T_map_cam) {
  stereo::DepthMap depth{kCamera, cv::Mat1f(128, 160, 0.0F), cv::Mat1f(128, 160, 0.0F)};
  const Eigen::Vector3d size(kLength, kWidth, kHeight), eye = T_map_cam.translation();
  for (int v = 0; v < 128; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Eigen::Vector3d ray = T_map_cam.linear() * kCamera.unproject(u, v, 1);
      double z = 1e9;
      for (int k = 0; k < 3; ++k) {
        if (ray[k] != 0) z = std::min(z, ((ray[k] > 0 ? size[k] : 0) - eye[k]) / ray[k]);
      }
      if (z < 0.3) continue;
      depth.depth_m(v, u) = static_cast<float>(z);
      depth.sigma_m(v, u) = 0.005F;
    }
  }
  return depth;
}

ExplorerParams params() {
  ExplorerParams params;
  params.led = true;
  params.tsdf.voxel_m = 0.1;
  return params;
}

class LedExplorerTest : public testing::Test {
 protected:
  LedExplorerTest() {
    mapping::PatchBuilder builder({}, params().tsdf, "R9", "world");
    for (double x = 1; x < kLength - 0.5; x += 0.5) {
      // Forwards only: behind the start surface stays incomplete.
      for (int i = -2; i <= 2; ++i) {
        const Pose2 body{x, 1.5, i * std::numbers::pi / 6};
        const Pose T = body.to_pose() * T_body_cam();
        for (const auto& patch : builder.add({Time{}, render(T), T, body, 0, 0})) EXPECT_TRUE(explorer_.fuse(patch));
      }
    }
    explorer_.begin(start_);
    // One picture of its own: what was fused is looked at with it.
    const Pose T = start_.to_pose() * T_body_cam();
    explorer_.integrate(render(T), T, start_);
  }

  /// An element of the surface that is still incomplete, or one that does not matter if there is none.
  Viewpoint there() const { return {{5.5, 1.5, 0}, incomplete(), 4}; }
  [[nodiscard]] std::vector<VoxelIndex> incomplete() const {
    mapping::IncompleteSurface surface;
    surface.update(explorer_.map());
    std::vector<VoxelIndex> voxels;
    for (const auto& element : surface.elements(explorer_.map())) voxels.push_back(element.voxel);
    return voxels;
  }
  ExplorerOrder step(bool pushes = false) {
    now_ += std::chrono::milliseconds(200);
    return explorer_.step(now_, start_, {.pushes = pushes});
  }
  /// It stands for some seconds on its way straight ahead, backs off, and is sent there again: whether its way leads
  /// over where its bow was.
  bool drives_on_after_standing(bool pushes) {
    start_.x_m += 1.5;  // where it started, the ground is free whatever happens
    explorer_.follow({there()}, now_);
    EXPECT_EQ(step().kind, Kind::kDrive);
    ExplorerOrder order;
    for (int i = 0; i < 30 && !order.piece.backwards; ++i) order = step(pushes);
    EXPECT_TRUE(order.piece.backwards);
    const Pose2 stood = start_;
    start_.x_m = order.piece.points_m.back().x();
    (void)explorer_.step(now_, start_, {.arrived = true});
    Viewpoint nearer = there();
    nearer.pose.x_m -= 0.5;  // another target: the first was given up
    explorer_.follow({nearer}, now_);
    order = {};
    for (int i = 0; i < 30 && order.kind != Kind::kDrive; ++i) order = step();
    EXPECT_EQ(order.kind, Kind::kDrive);
    const Eigen::Vector2d bow_m = stood.position_m() + Eigen::Vector2d(0.55, 0);
    return std::any_of(order.piece.points_m.begin(), order.piece.points_m.end(),
                       [&](const Eigen::Vector2d& p_m) { return (p_m - bow_m).norm() < 0.2; });
  }

  Explorer explorer_{params(), make_level_camera({kCamera, 0.26}, T_body_cam(), 0.3, 5.0)};
  Pose2 start_{1.5, 1.5, 0};
  Time now_{std::chrono::seconds(100)};
};

TEST_F(LedExplorerTest, PlansNothingByItselfAndDrivesWhereItIsSentOverGroundThatOnlyATeammateSaw) {
  // Sent nowhere, it turns about once, in three pieces.
  for (int i = 0; i < 3; ++i) {
    const ExplorerOrder turn = explorer_.step(now_, start_, {.arrived = true});
    ASSERT_EQ(turn.kind, Kind::kDrive);
    EXPECT_LT((turn.piece.points_m.back() - start_.position_m()).norm(), 0.05);
  }
  EXPECT_NE(explorer_.step(now_, start_, {.arrived = true}).kind, Kind::kDrive);
  EXPECT_TRUE(explorer_.idle());
  ASSERT_FALSE(there().elements.empty());
  explorer_.follow({there()}, now_);
  const ExplorerOrder order = step();
  ASSERT_EQ(order.kind, Kind::kDrive);
  EXPECT_LT((order.piece.points_m.back() - Eigen::Vector2d(5.5, 1.5)).norm(), 0.3);
  EXPECT_FALSE(explorer_.idle());
  ASSERT_TRUE(explorer_.target());
  EXPECT_EQ(*explorer_.target(), there().pose);
}

TEST_F(LedExplorerTest, ATeammateThatFillsTheLaneKeepsItFromItsTourUntilItHasMoved) {
  const std::vector<Pose2> wall{
      {3.5, 0.5, std::numbers::pi / 2}, {3.5, 1.5, std::numbers::pi / 2}, {3.5, 2.5, std::numbers::pi / 2}};
  explorer_.set_traffic(wall, TrafficAdvice::kGo);
  explorer_.follow({there()}, now_);
  for (int i = 0; i < 8; ++i) EXPECT_NE(step().kind, Kind::kDrive);
  EXPECT_TRUE(explorer_.kept_by_bodies());
  EXPECT_TRUE(explorer_.take_events().empty()) << "it may be reached later";
  explorer_.set_traffic({}, TrafficAdvice::kGo);
  bool drives = false;
  for (int i = 0; i < 8 && !drives; ++i) drives = step().kind == Kind::kDrive;
  EXPECT_TRUE(drives);
  EXPECT_FALSE(explorer_.kept_by_bodies());
}

TEST_F(LedExplorerTest, WhatStaysBlockedIsGivenUpAndReported) {
  explorer_.set_traffic({{3.5, 0.5, 1.57}, {3.5, 1.5, 1.57}, {3.5, 2.5, 1.57}}, TrafficAdvice::kGo);
  explorer_.follow({there()}, now_);
  std::vector<TargetEvent> events;
  for (int i = 0; i < 60 && events.empty(); ++i) {
    (void)step();
    events = explorer_.take_events();
  }
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events[0].kind, TargetEvent::Kind::kUnreachable);
  EXPECT_EQ(events[0].target, there().pose);
  EXPECT_FALSE(explorer_.target());
}

TEST_F(LedExplorerTest, ItStandsWhileTrafficSaysSoAndGoesOnAfterwards) {
  explorer_.follow({there()}, now_);
  ASSERT_EQ(step().kind, Kind::kDrive);
  explorer_.set_traffic({}, TrafficAdvice::kYield);
  EXPECT_EQ(step().kind, Kind::kStop);
  explorer_.set_traffic({}, TrafficAdvice::kGo);
  EXPECT_EQ(step().kind, Kind::kDrive);
}

TEST_F(LedExplorerTest, StoppedForWhatIsInItsWayItGetsItsLegAnewTwiceAtAPlaceAndThenCountsAsStuck) {
  start_.x_m += 1.5;
  explorer_.follow({there()}, now_);
  ASSERT_EQ(step().kind, Kind::kDrive);
  for (int stop = 0; stop < 2; ++stop) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(explorer_.step(now_, start_, {.blocked = true}).kind, Kind::kGoOn);
    const ExplorerOrder again = step();
    ASSERT_EQ(again.kind, Kind::kDrive) << stop;
    EXPECT_FALSE(again.piece.backwards);
    EXPECT_LT((again.piece.points_m.back() - there().pose.position_m()).norm(), 0.3);
  }
  EXPECT_EQ(explorer_.step(now_, start_, {.blocked = true}).kind, Kind::kGoOn);
  ExplorerOrder order;
  for (int i = 0; i < 30 && order.kind != Kind::kDrive; ++i) order = step();
  EXPECT_TRUE(order.piece.backwards);
  ASSERT_FALSE(explorer_.take_events().empty()) << "its target is given up";
}

TEST_F(LedExplorerTest, WhatItPushesAgainstIsInItsWay) {
  EXPECT_FALSE(drives_on_after_standing(true));
}

TEST_F(LedExplorerTest, WhereItWasStoppedItMayDriveAgain) {
  EXPECT_TRUE(drives_on_after_standing(false));
}

TEST_F(LedExplorerTest, ItStepsAsideForATeammateAndIsDoneWhenTheTeamIs) {
  EXPECT_FALSE(explorer_.step_aside(now_, {1.5, 0.8, 0}, {5.5, 2.3, 3}, {4.5, 2.3, 3}, 0.95)) << "it is not in the way";
  start_ = {3.5, 1.5, 0};
  ASSERT_TRUE(explorer_.step_aside(now_, start_, {5.5, 2.2, 3.1}, {1.5, 2.2, 3.1}, 0.95));
  const ExplorerOrder order = explorer_.step(now_, start_, {.arrived = true});
  ASSERT_EQ(order.kind, Kind::kDrive);
  EXPECT_LT(order.piece.points_m.back().y(), 1.35);
  explorer_.finish();
  EXPECT_TRUE(explorer_.status().done);
}

}  // namespace
}  // namespace arpent::planning
