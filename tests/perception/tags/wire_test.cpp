// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/wire.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace arpent::tags {
namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();

Matrix6d ramp() {
  Matrix6d matrix;
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) matrix(r, c) = 1 + 10 * r + c;
  }
  return matrix;
}

Pose some_pose() {
  return retract(Pose::Identity(), (Vector6d() << 1, 2, 3, 0.1, 0.2, 0.3).finished());
}

BodyObservation observation() {
  BodyObservation o{from_utime(12), 13, {}, true, "", some_pose(), ramp()};
  o.tags.push_back({14, 1, 16.5, {Eigen::Vector2d(21, 22), {23, 24}, {25, 26}, {27, 28}}});
  o.tags.push_back({586, 0, 17.5, {Eigen::Vector2d(31, 32), {33, 34}, {35, 36}, {37, 38}}});
  return o;
}

TEST(TagWire, AnObservationComesBackAsItWentOut) {
  const tag_observation_t message = to_wire(observation());
  EXPECT_EQ(message.utime, 12);
  EXPECT_EQ(message.count, 2);
  EXPECT_EQ(message.covariance[1][2], 13);
  EXPECT_EQ(message.tags[0].corners_px[2][1], 26);
  const auto back = from_wire(message);
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, from_utime(12));
  EXPECT_EQ(back->sequence, 13);
  EXPECT_TRUE(back->accepted);
  EXPECT_TRUE(back->T_world_body.isApprox(some_pose(), 1e-12));
  EXPECT_EQ(back->covariance, ramp());
  ASSERT_EQ(back->tags.size(), 2U);
  EXPECT_EQ(back->tags[0].id, 14);
  EXPECT_EQ(back->tags[0].hamming, 1);
  EXPECT_EQ(back->tags[0].decision_margin, 16.5);
  EXPECT_EQ(back->tags[0].corners_px[3], Eigen::Vector2d(27, 28));
  BodyObservation rejected = observation();
  rejected.accepted = false;
  rejected.reason = "two poses fit the tags";
  rejected.covariance.setZero();
  const auto why = from_wire(to_wire(rejected));
  ASSERT_TRUE(why) << why.fault();
  EXPECT_FALSE(why->accepted);
  EXPECT_EQ(why->reason, "two poses fit the tags");
}

TEST(TagWire, ABadObservationIsRefusedWithItsReason) {
  const auto fault = [](const std::function<void(tag_observation_t&)>& damage) {
    tag_observation_t message = to_wire(observation());
    damage(message);
    return from_wire(message).fault();
  };
  EXPECT_EQ(fault([](auto&) {}), "");
  EXPECT_EQ(fault([](auto& m) { m.frame = "odom"; }), "frames are not world and body");
  EXPECT_EQ(fault([](auto& m) { m.child_frame = ""; }), "frames are not world and body");
  EXPECT_EQ(fault([](auto& m) { m.accepted = 2; }), "accepted is neither 0 nor 1");
  EXPECT_EQ(fault([](auto& m) { m.position_m[1] = kNan; }), "the pose is not a rigid motion");
  EXPECT_EQ(fault([](auto& m) { m.orientation_wxyz[0] = 2; }), "the pose is not a rigid motion");
  EXPECT_EQ(fault([](auto& m) { m.covariance[2][3] = kNan; }), "the covariance is not finite");
  EXPECT_EQ(fault([](auto& m) { m.covariance[2][2] = 0; }), "an accepted pose has a variance that is not positive");
  EXPECT_EQ(fault([](auto& m) { m.tags[1].id = 587; }), "a tag's id is not of the family");
  EXPECT_EQ(fault([](auto& m) { m.tags[1].hamming = -1; }), "a tag's quality is out of range");
  EXPECT_EQ(fault([](auto& m) { m.tags[0].corners_px[3][1] = kNan; }), "a tag's corner is not finite");
}

TEST(TagWire, AnAlignmentComesBackAsItWentOutAndABadOneIsRefused) {
  const Alignment alignment{from_utime(77), some_pose(), ramp(), 5, 0};
  const auto back = from_wire(to_wire(alignment));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->stamp, from_utime(77));
  EXPECT_TRUE(back->T_world_odom.isApprox(some_pose(), 1e-12));
  EXPECT_EQ(back->covariance, ramp());
  EXPECT_EQ(back->views, 5);
  const auto fault = [&](const std::function<void(frame_alignment_t&)>& damage) {
    frame_alignment_t message = to_wire(alignment);
    damage(message);
    return from_wire(message).fault();
  };
  EXPECT_EQ(fault([](auto& m) { m.child_frame = "body"; }), "frames are not world and odom");
  EXPECT_EQ(fault([](auto& m) { m.views = 0; }), "it was made from no view");
  EXPECT_EQ(fault([](auto& m) { m.orientation_wxyz[1] = kNan; }), "the pose is not a rigid motion");
  EXPECT_EQ(fault([](auto& m) { m.covariance[5][5] = -1; }), "a variance is not positive");
}

}  // namespace
}  // namespace arpent::tags
