// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Robots that jump to where the centre sends them complete a room; who dies is planned around, and the team comes to an
// end.
#include "planning/team/centre.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "mapping/exchange/patch_builder.h"

namespace arpent::planning {
namespace {

constexpr double kLength = 7.0, kWidth = 5.0, kHeight = 1.8;
const PinholeCamera kCamera{160, 128, 94.25, 94.25, 79.5, 63.5};

Pose T_body_cam() {
  Pose T = Pose::Identity();
  T.linear() = R_body_from_camera_axes();
  T.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return T;
}

/// Depth images of an empty room with one corner at the origin.
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

mapping::TsdfParams lattice() {
  mapping::TsdfParams params;
  params.voxel_m = 0.2;
  return params;
}

CentreParams params() {
  CentreParams params;
  params.tsdf = lattice();
  params.grid.robot_height_m = 0.6;
  params.region_max_m = {kLength + 0.1, kWidth + 0.1, kHeight - 0.1};
  params.region_min_m = {-0.1, -0.1, -1};
  params.viewpoints.least_piece_m = 0;  // the room is small, its pieces too
  return params;
}

/// A robot that is wherever it was sent.
struct Jumper {
  std::string name;
  Pose2 at;
  bool dead = false;
  std::int64_t tour = -1;
  std::vector<Viewpoint> left = {};
  mapping::PatchBuilder builder{{}, lattice(), name, "world"};

  void look(Centre& centre, Time now) {
    const Pose T = at.to_pose() * T_body_cam();
    const stereo::DepthMap depth = render(T);
    for (const auto& patch : builder.add({now, depth, T, at, 0.01, 0.001})) ASSERT_TRUE(centre.take(patch));
  }
  [[nodiscard]] RobotState state(Time now) const {
    RobotState state;
    state.stamp = now;
    state.robot = name;
    state.state = MissionState::kRunning;
    state.body = at;
    state.tour = tour;
    state.idle = left.empty();
    if (!left.empty()) state.target = left.front().pose;
    return state;
  }
};

class CentreTest : public testing::Test {
 protected:
  /// One second: each robot looks five times from where it is, and goes on.
  void second() {
    for (int tick = 0; tick < 10; ++tick) {
      now_ += std::chrono::milliseconds(100);
      for (Jumper& robot : robots_) {
        if (robot.dead) continue;
        if (tick % 2 == 0) robot.look(centre_, now_);
        centre_.take(robot.state(now_), now_);
      }
      for (const TeamTour& tour : centre_.step(now_)) take(tour);
    }
    for (Jumper& robot : robots_) {
      if (robot.dead || robot.left.empty()) continue;
      if (robot.at == robot.left.front().pose) {
        centre_.take(TourReport{now_, robot.name, {TargetEvent::Kind::kVisited, robot.at}}, now_);
        robot.left.erase(robot.left.begin());
      }
      if (!robot.left.empty()) robot.at = robot.left.front().pose;
    }
  }

  void take(const TeamTour& tour) {
    numbers_.insert(tour.number);
    for (Jumper& robot : robots_) {
      if (robot.name != tour.robot) continue;
      EXPECT_TRUE(robot.dead || now_ - tour.state_stamp <= std::chrono::seconds(1)) << "planned from a fresh state";
      robot.tour = tour.number;
      robot.left = tour.viewpoints;
      done_ = done_ || tour.done;
    }
  }

  /// Looks about from the start.
  void begin() {
    for (int i = 0; i < 8; ++i) {
      for (Jumper& robot : robots_) robot.at.yaw_rad = i * std::numbers::pi / 4;
      second();
    }
  }

  Centre centre_{params(), make_level_camera({kCamera, 0.26}, T_body_cam(), 0.3, 5.0)};
  std::vector<Jumper> robots_;
  Time now_{std::chrono::seconds(100)};
  std::set<std::int64_t> numbers_;
  bool done_ = false;
};

TEST_F(CentreTest, TwoRobotsCompleteTheRoomAndTheTeamEnds) {
  robots_.push_back({"R1", {1.5, 1.5, 0}});
  robots_.push_back({"R2", {5.5, 3.5, 0}});
  begin();
  int seconds = 0;
  bool both_work = false;
  for (; seconds < 120 && !done_; ++seconds) {
    second();
    both_work = both_work || (!robots_[0].left.empty() && !robots_[1].left.empty());
  }
  EXPECT_TRUE(done_) << centre_.status().elements << " elements, " << centre_.status().clusters << " clusters left";
  EXPECT_TRUE(both_work);
  EXPECT_LT(seconds, 120);
  // The floor of the room is known, but for what the camera cannot see before walls.
  int known = 0, all = 0;
  for (double x = 0.7; x < kLength - 0.7; x += 0.2) {
    for (double y = 0.7; y < kWidth - 0.7; y += 0.2) {
      ++all;
      known += centre_.map().is_known(centre_.map().index_of({x, y, 0.1})) ? 1 : 0;
    }
  }
  EXPECT_GT(known, all * 95 / 100);
}

TEST_F(CentreTest, WhatADeadRobotWasGivenGoesToTheOtherWithinSeconds) {
  robots_.push_back({"R1", {1.5, 1.5, 0}});
  robots_.push_back({"R2", {5.5, 3.5, 0}});
  begin();
  robots_[1].dead = true;
  int seconds = 0;
  for (; seconds < 10 && centre_.status().lost == 0; ++seconds) second();
  EXPECT_EQ(centre_.status().lost, 1);
  EXPECT_LE(seconds, 3);
  for (seconds = 0; seconds < 150 && !done_; ++seconds) second();
  EXPECT_TRUE(done_);
}

TEST_F(CentreTest, AViewpointThatCannotBeReachedIsLeftOutForAWhile) {
  robots_.push_back({"R1", {1.5, 1.5, 0}});
  begin();
  for (int i = 0; i < 5 && robots_[0].left.empty(); ++i) second();
  ASSERT_FALSE(robots_[0].left.empty());
  const Pose2 bad = robots_[0].left.front().pose;
  centre_.take(TourReport{now_, "R1", {TargetEvent::Kind::kUnreachable, bad}}, now_);
  robots_[0].left.clear();
  robots_[0].at = {1.5, 1.5, 0};
  for (int tick = 0; tick < 20; ++tick) {
    now_ += std::chrono::milliseconds(100);
    centre_.take(robots_[0].state(now_), now_);
    for (const TeamTour& tour : centre_.step(now_)) {
      if (tick < 4) continue;  // planned before the report
      for (const Viewpoint& viewpoint : tour.viewpoints) EXPECT_FALSE(viewpoint.pose == bad);
    }
  }
}

TEST_F(CentreTest, APatchTwiceIsFusedOnce) {
  Jumper robot{"R1", {1.5, 1.5, 0}};
  const Pose T = robot.at.to_pose() * T_body_cam();
  const stereo::DepthMap depth = render(T);
  std::vector<mapping::MapPatch> patches;
  while (patches.empty()) patches = robot.builder.add({now_, depth, T, robot.at, 0, 0});
  ASSERT_GT(*centre_.take(patches[0]), 0U);
  const std::int64_t revision = centre_.map().revision();
  EXPECT_EQ(*centre_.take(patches[0]), 0U);
  EXPECT_EQ(centre_.map().revision(), revision);
  patches[0].sequence = 99;
  patches[0].voxel_m = 0.1;
  EXPECT_FALSE(centre_.take(patches[0]));
}

}  // namespace
}  // namespace arpent::planning
