// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/stop_guard.h"

#include <gtest/gtest.h>

#include <random>

#include "common/error.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

Pose T_body_cam() {
  Pose T = Pose::Identity();
  T.linear() = R_body_from_camera_axes();
  T.translation() = Eigen::Vector3d(0.2, 0, 0.4);
  return T;
}

/// A board across the way (x = `ahead_m` in body coordinates, y in [left, right], z up to `top_m`) over a floor.
stereo::DepthMap look_at_board(double ahead_m, double right_m, double left_m, double top_m = 2, double bottom_m = 0) {
  stereo::DepthMap depth;
  depth.camera = {640, 512, 377, 377, 319.5, 255.5};
  depth.depth_m = cv::Mat1f::zeros(512, 640);
  const Pose T = T_body_cam();
  for (int v = 0; v < 512; ++v) {
    for (int u = 0; u < 640; ++u) {
      const Eigen::Vector3d ray = T.linear() * depth.camera.unproject(u, v, 1);
      double z = 0;
      if (ray.z() < -0.05) z = 0.4 / -ray.z();
      const double to_board = ahead_m - 0.2;
      const Eigen::Vector3d p = T.translation() + to_board * ray;
      const bool meets = p.y() >= right_m && p.y() <= left_m && p.z() >= bottom_m && p.z() <= top_m;
      if (meets && (z == 0 || to_board < z)) z = to_board;
      depth.depth_m(v, u) = z > 0.3 && z < 5 ? static_cast<float>(z) : 0.0F;
    }
  }
  return depth;
}

StopGuard make_guard() {
  return StopGuard({}, Footprint({}));
}
StopDecision look(const stereo::DepthMap& depth, const Twist2& twist) {
  return make_guard().look(depth, T_body_cam(), twist);
}

TEST(StopGuard, LooksAsFarAsItTakesToStop) {
  // v^2 / 2a + delay v + margin = 0.25 + 0.175 + 0.1
  EXPECT_NEAR(look(look_at_board(4, -2, 2), {0.5, 0}).looked_at_m, 0.525, 1e-9);
  EXPECT_FALSE(look(look_at_board(1.25, -2, 2), {0.5, 0}).stop) << "0.7 m before the ellipse's nose";
  const auto stop = look(look_at_board(1.0, -2, 2), {0.5, 0});
  EXPECT_TRUE(stop.stop);
  EXPECT_NEAR(stop.free_m, 1.0 - 0.55 - 0.03, 0.05);
  EXPECT_FALSE(look(look_at_board(1.0, -2, 2), {0.2, 0}).stop) << "slower is shorter";
}

TEST(StopGuard, OnlyWhatTheFootprintWouldMeetCounts) {
  EXPECT_FALSE(look(look_at_board(0.9, 0.32, 2), {0.5, 0}).stop) << "beside";
  EXPECT_TRUE(look(look_at_board(0.9, 0.15, 2), {0.5, 0}).stop);
  EXPECT_FALSE(look(look_at_board(0.9, -2, 2, 2, 0.65), {0.5, 0}).stop) << "above";
  EXPECT_FALSE(look(look_at_board(4, -2, 2), {0.5, 0}).stop) << "the floor";
  EXPECT_TRUE(look(look_at_board(0.9, -0.02, 0.02), {0.5, 0}).stop) << "a pole of 4 cm";
  // In a left turn of 0.5 m radius what is ahead on the right is passed, what is on the left is met.
  EXPECT_FALSE(look(look_at_board(1.0, -0.6, -0.25), {0.5, 1}).stop);
  EXPECT_TRUE(look(look_at_board(0.68, 0.2, 0.7), {0.5, 1}).stop);
  EXPECT_FALSE(look(look_at_board(0.9, -2, 2), {-0.3, 0}).stop) << "backwards it cannot see";
  EXPECT_FALSE(look(look_at_board(0.7, -2, 2), {0, 0}).stop) << "standing";
}

TEST(StopGuard, ATurnOnTheSpotStopsBeforeWhatStandsInItsCircle) {
  const Twist2 left{0, 1};
  EXPECT_TRUE(look(look_at_board(0.52, 0.2, 0.5), left).stop);
  EXPECT_FALSE(look(look_at_board(0.52, 0.2, 0.5), {0, -1}).stop) << "turns away from it";
  EXPECT_FALSE(look(look_at_board(0.65, 0.2, 0.5), left).stop) << "out of the circle";
}

TEST(StopGuard, AFewNoisyPixelsDoNotStopIt) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    stereo::DepthMap depth = look_at_board(4, -2, 2);
    for (int i = 0; i < 100; ++i) {  // flying pixels anywhere near
      depth.depth_m(static_cast<int>(random() % 512), static_cast<int>(random() % 640)) =
          static_cast<float>(uniform(random, 0.3, 0.9));
    }
    for (int v = 250; v < 256; ++v) {  // and a speckle of 6 x 6 right ahead
      for (int u = 300; u < 306; ++u) depth.depth_m(v, u) = 0.6F;
    }
    EXPECT_FALSE(look(depth, {0.5, 0}).stop);
  }
  stereo::DepthMap blind = look_at_board(4, -2, 2);
  blind.depth_m.setTo(std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(look(blind, {0.5, 0}).stop) << "what is missing is for others to watch";
}

TEST(StopGuard, AStopEndsAfterSeveralClearImages) {
  StopGuard guard = make_guard();
  const auto wall = look_at_board(0.9, -2, 2), free = look_at_board(4, -2, 2);
  EXPECT_TRUE(guard.look(wall, T_body_cam(), {0.5, 0}).stop);
  EXPECT_TRUE(guard.look(free, T_body_cam(), {0.2, 0}).stop);
  EXPECT_TRUE(guard.look(free, T_body_cam(), {0, 0}).stop);
  EXPECT_FALSE(guard.look(free, T_body_cam(), {0, 0}).stop);
  EXPECT_THROW(StopGuard({0.5, 3, 0.35, 0.1, 0.03, 0.7, 0.6}, Footprint({})), InputError);
}

TEST(StopGuard, BrakingInTimeLeavesTenCentimetresWhateverTheMomentOfThePicture) {
  // The base: 5 Hz pictures, 0.15 s until it brakes, then 0.5 m/s2 (or more, as the parameter says). A wall that was
  // always there, at any phase of the camera.
  for (const double speed : {0.2, 0.5, 1.0}) {
    for (int phase = 0; phase < 10; ++phase) {
      StopGuard guard = make_guard();
      double x = 0, v = speed, picture = 0.02 * phase, brake_at = 1e9;
      constexpr double kWall = 4.0, kDt = 0.01;
      for (double t = 0; t < 40 && v > 0; t += kDt) {
        if (t >= picture) {
          picture += 0.2;
          std::vector<Eigen::Vector3d> points;
          for (int i = 0; i < 100; ++i) points.emplace_back(kWall - x, 0.005 * (i - 50), 0.3);
          if (guard.look(points, {v, 0}).stop) brake_at = std::min(brake_at, t + 0.15);
        }
        if (t >= brake_at) v = std::max(0.0, v - 0.5 * kDt);
        x += v * kDt;
      }
      EXPECT_EQ(v, 0);
      EXPECT_GE(kWall - x - 0.55, 0.1) << "at " << speed << " m/s, phase " << phase;
      EXPECT_LE(kWall - x - 0.55, 0.1 + 0.03 + 0.25 * speed + 0.05) << "and not much earlier than it must";
    }
  }
}

}  // namespace
}  // namespace arpent::planning
