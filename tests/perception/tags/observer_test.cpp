// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/observer.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/perception/tags/cube_pictures.h"

namespace arpent::tags {
namespace {

TagObserver make_observer(const GroundParams& ground = {}) {
  return {{}, {}, ground, make_stereo(), make_T_body_cam()};
}

/// Views all around at 1 to 3 m.
Pose pose_number(int i) {
  return pose_facing({}, 1.0 + 0.1 * (i % 20), 0.37 * i, 0.1 * std::sin(i));
}

/// How many of `count` pictures are accepted.
int accepted(int count, const PictureOptions& options) {
  const TagObserver observer = make_observer();
  int sum = 0;
  for (int i = 0; i < count; ++i) {
    const auto pair = render_cube({}, pose_number(i), static_cast<std::uint64_t>(i), options);
    sum += observer.observe(pair.left, pair.right).accepted();
  }
  return sum;
}

TEST(TagObserver, SaysWhereTheBodyStandsToMillimetresAndMilliradians) {
  const TagObserver observer = make_observer();
  std::vector<double> position_m, yaw_rad;
  double nees = 0;
  constexpr int kViews = 40;
  for (int i = 0; i < kViews; ++i) {
    const Pose truth = pose_facing({}, 2.0, 0.157 * i, 0.2 * std::sin(i));
    const auto pair = render_cube({}, truth, static_cast<std::uint64_t>(i));
    const Observation seen = observer.observe(pair.left, pair.right);
    ASSERT_TRUE(seen.accepted()) << i << ": " << seen.reason;
    const Vector6d d = local(truth, seen.T_world_body);
    position_m.push_back(d.head<3>().norm());
    yaw_rad.push_back(std::abs(d[5]));
    const Vector6d raw = local(truth, seen.measured.T_world_body);
    nees += raw.dot(seen.measured.covariance.ldlt().solve(raw)) / 6 / kViews;
  }
  std::sort(position_m.begin(), position_m.end());
  std::sort(yaw_rad.begin(), yaw_rad.end());
  EXPECT_LT(position_m[kViews / 2], 0.004);
  EXPECT_LT(position_m.back(), 0.02);
  EXPECT_LT(yaw_rad[kViews / 2], 0.002);
  EXPECT_LT(yaw_rad.back(), 0.01);
  EXPECT_GT(nees, 0.3);
  EXPECT_LT(nees, 2.0);
}

TEST(TagObserver, WorksWithBlurAndLittleLight) {
  PictureOptions options;
  options.motion_px = 2;
  EXPECT_GE(accepted(10, options), 8);
  options.motion_px = 0;
  options.light = 0.35;
  EXPECT_GE(accepted(10, options), 8);
}

TEST(TagObserver, AcceptsNothingOfOtherTags) {
  PictureOptions options;
  options.painted_ids = {10, 11, 12, 13};
  EXPECT_EQ(accepted(20, options), 0);
  const auto pair = render_cube({}, pose_number(0), 1, options);
  const Observation seen = make_observer().observe(pair.left, pair.right);
  EXPECT_FALSE(seen.tags.empty()) << "they are reported";
  EXPECT_EQ(seen.reason, "no tag of the cube was seen in both images");
}

TEST(TagObserver, AcceptsNothingOfAnotherSize) {
  PictureOptions options;
  options.true_tag_m = 0.20;
  EXPECT_EQ(accepted(10, options), 0);
  options.true_tag_m = 0.26;
  EXPECT_EQ(accepted(10, options), 0);
}

TEST(TagObserver, AcceptsNothingThatIsHalfCovered) {
  PictureOptions options;
  for (const double grey : {110.0, 18.0, 205.0}) {
    options.card_grey = grey;
    options.card_left = -0.2, options.card_right = 0.5, options.card_bottom = -0.2, options.card_top = 1.2;
    EXPECT_EQ(accepted(10, options), 0) << "left half, grey " << grey;
    options.card_right = 1.2, options.card_bottom = 0.5;
    EXPECT_EQ(accepted(10, options), 0) << "upper half, grey " << grey;
  }
  // A black card that makes the black square wider: its bits can still be read.
  options.card_grey = 18;
  options.card_left = 0.97, options.card_right = 1.05, options.card_bottom = -0.02, options.card_top = 1.02;
  EXPECT_EQ(accepted(20, options), 0);
}

TEST(TagObserver, SeesNoTagWithoutTheCubeAndNoneInOneImageOnly) {
  PictureOptions options;
  options.with_cube = false;
  EXPECT_EQ(accepted(10, options), 0);
  const auto pair = render_cube({}, pose_facing({}, 1.5, 0.3, 0), 1);
  const auto empty = render_cube({}, pose_facing({}, 1.5, 0.3, 0), 2, options);
  EXPECT_FALSE(make_observer().observe(pair.left, empty.right).accepted());
  EXPECT_EQ(make_observer().observe(empty.left, pair.right).reason, "no tag");
}

TEST(TagObserver, ABodyThatDoesNotStandOnTheGroundIsReported) {
  const TagObserver observer = make_observer();
  const auto reason_at = [&](const Vector6d& off) {
    const auto pair = render_cube({}, retract(pose_facing({}, 1.5, M_PI / 4, 0), off), 1);
    return observer.observe(pair.left, pair.right).reason;
  };
  EXPECT_EQ(reason_at(Vector6d::Zero()), "");
  EXPECT_EQ(reason_at(0.01 * Vector6d::Unit(2)), "") << "a doorstep of a centimetre";
  EXPECT_EQ(reason_at(0.12 * Vector6d::Unit(2)), "the tags put the body off the ground");
  EXPECT_EQ(reason_at(0.08 * Vector6d::Unit(4)), "the tags put the body off the ground") << "pitched by 4.6 degrees";
}

TEST(TagObserver, IsDeterministic) {
  const auto pair = render_cube({}, pose_number(3), 3);
  const TagObserver observer = make_observer();
  const Observation a = observer.observe(pair.left, pair.right);
  (void)observer.observe(pair.right, pair.left);
  const Observation b = observer.observe(pair.left, pair.right);
  EXPECT_EQ(a.T_world_body.matrix(), b.T_world_body.matrix());
  EXPECT_EQ(a.covariance, b.covariance);
}

}  // namespace
}  // namespace arpent::tags
