// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/wire.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace arpent::fusion {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

FusedPose distinct_pose() {
  FusedPose pose;
  pose.stamp = from_utime(11);
  pose.frame = Frame::kWorld;
  pose.T_frame_body = Eigen::Translation3d(1, 2, 3) * Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 2) / 3);
  pose.twist = {0.5, 0.6};
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) pose.covariance(r, c) = r == c ? 10 + r : 0.01 * (r * c + r + c);
  }
  pose.status = Status::kDeadReckoning;
  pose.reason = "why";
  pose.odometry_stamp = from_utime(9);
  return pose;
}

wheel_state_t wheels() {
  wheel_state_t m{};
  m.utime = 5;
  m.left_m = 1.5;
  m.right_m = 2.5;
  m.commanded_speed_mps = 0.3;
  m.commanded_turn_rate_radps = 0.4;
  m.heard = 1;
  return m;
}

TEST(FusionWire, APoseComesBackAsItWas) {
  const FusedPose pose = distinct_pose();
  const body_pose_t message = to_wire(pose, 7);
  EXPECT_EQ(message.sequence, 7);
  EXPECT_EQ(message.covariance[1][4], pose.covariance(1, 4));
  const auto back = from_wire(message);
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, pose.stamp);
  EXPECT_EQ(back->frame, pose.frame);
  EXPECT_LT(local(pose.T_frame_body, back->T_frame_body).norm(), 1e-12);
  EXPECT_EQ(back->twist, pose.twist);
  EXPECT_EQ(back->covariance, pose.covariance);
  EXPECT_EQ(back->status, pose.status);
  EXPECT_EQ(back->reason, pose.reason);
  EXPECT_EQ(back->odometry_stamp, pose.odometry_stamp);
}

TEST(FusionWire, BadPosesAreRefused) {
  const std::function<void(body_pose_t&)> damages[] = {
      [](body_pose_t& m) { m.frame = "map"; },           [](body_pose_t& m) { m.child_frame = "cam0"; },
      [](body_pose_t& m) { m.position_m[2] = kNan; },    [](body_pose_t& m) { m.position_m[0] = 1e9; },
      [](body_pose_t& m) { m.orientation_wxyz[0] = 3; }, [](body_pose_t& m) { m.covariance[3][3] = -1; },
      [](body_pose_t& m) { m.covariance[0][1] = 1e3; },  [](body_pose_t& m) { m.covariance[0][0] = kNan; },
      [](body_pose_t& m) { m.velocity_mps[0] = kNan; },  [](body_pose_t& m) { m.status = 3; },
  };
  for (const auto& damage : damages) {
    body_pose_t message = to_wire(distinct_pose(), 1);
    damage(message);
    EXPECT_FALSE(from_wire(message));
  }
}

TEST(FusionWire, WheelsAreReadAndUnheardOrFaultyOnesAreNotUsed) {
  const auto reading = from_wire(wheels());
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->stamp, from_utime(5));
  EXPECT_EQ(reading->left_m, 1.5);
  EXPECT_EQ(reading->right_m, 2.5);
  EXPECT_EQ(reading->commanded, (Twist2{0.3, 0.4}));
  EXPECT_TRUE(reading->usable);
  wheel_state_t unheard = wheels(), faulty = wheels(), broken = wheels();
  unheard.heard = 0;
  faulty.fault = "left odometer stuck";
  broken.right_m = kNan;
  EXPECT_FALSE(from_wire(unheard)->usable);
  EXPECT_FALSE(from_wire(faulty)->usable);
  EXPECT_FALSE(from_wire(broken));
}

TEST(FusionWire, TheYawRateIsTheThirdAndEveryRateMustBeOne) {
  imu_t m{};
  m.utime = 3;
  m.angular_velocity_radps[0] = 0.1;
  m.angular_velocity_radps[1] = 0.2;
  m.angular_velocity_radps[2] = 0.3;
  EXPECT_EQ(from_wire(m)->yaw_rate_radps, 0.3);
  EXPECT_EQ(from_wire(m)->stamp, from_utime(3));
  m.angular_velocity_radps[1] = kNan;
  EXPECT_FALSE(from_wire(m));
}

TEST(FusionWire, OdometryTagsAndAlignmentsAreChecked) {
  odometry_t o{};
  o.utime = 4;
  o.sequence = 2;
  o.frame = "odom";
  o.child_frame = "body";
  o.position_m[1] = 0.7;
  o.orientation_wxyz[0] = 1;
  o.covariance[0][0] = 1;
  o.step_covariance[5][5] = 2;
  o.status = odometry_t::STATUS_LOST;
  o.reason = "dark";
  EXPECT_FALSE(from_wire(o)->usable);
  EXPECT_FALSE(from_wire(o)->anchored);
  EXPECT_EQ(from_wire(o)->reason, "dark");
  o.keyframe = 1;
  EXPECT_TRUE(from_wire(o)->anchored);
  o.status = odometry_t::STATUS_DEGRADED;
  EXPECT_TRUE(from_wire(o)->usable);
  EXPECT_EQ(from_wire(o)->covariance(0, 0), 1);
  EXPECT_EQ(from_wire(o)->step_covariance(5, 5), 2);
  EXPECT_EQ(from_wire(o)->T_odom_body.translation().y(), 0.7);
  o.step_covariance[0][3] = 5;
  EXPECT_FALSE(from_wire(o));

  tag_observation_t t{};
  t.frame = "world";
  t.child_frame = "body";
  t.orientation_wxyz[0] = 1;
  t.position_m[0] = 4;
  EXPECT_FALSE(from_wire(t)) << "not accepted by its sender";
  t.accepted = 1;
  EXPECT_EQ(from_wire(t)->T_world_body.translation().x(), 4);
  t.frame = "odom";
  EXPECT_FALSE(from_wire(t));

  frame_alignment_t a{};
  a.frame = "world";
  a.child_frame = "odom";
  a.orientation_wxyz[0] = 1;
  a.position_m[2] = 5;
  EXPECT_EQ(from_wire(a)->T_world_odom.translation().z(), 5);
  a.covariance[2][2] = -1;
  EXPECT_FALSE(from_wire(a));
  a.covariance[2][2] = 0;
  a.child_frame = "body";
  EXPECT_FALSE(from_wire(a));
}

}  // namespace
}  // namespace arpent::fusion
