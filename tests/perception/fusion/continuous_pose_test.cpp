// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/continuous_pose.h"

#include <gtest/gtest.h>

#include "common/pose2.h"

namespace arpent::fusion {
namespace {

constexpr double kPeriodS = 0.02;

FusedPose pose(int i, const Pose2& at) {
  FusedPose p;
  p.stamp = from_utime(1000000) + from_seconds(i * kPeriodS);
  p.T_frame_body = at.to_pose();
  p.status = Status::kOk;
  return p;
}

/// At 0.5 m/s along x; from step 10 on everything, the past included, is known to be `off_m` to the side.
struct Corrected {
  double off_m;
  [[nodiscard]] FusedPose best(int i, int known_at) const {
    return pose(i, {0.5 * kPeriodS * i, known_at >= 10 ? off_m : 0, 0});
  }
};

TEST(ContinuousPose, ACorrectionComesInWithinThreeTimeConstantsAndNoStepJumps) {
  const BlendParams params;
  const Corrected robot{0.02};
  ContinuousPose continuous(params);
  Pose last = Pose::Identity();
  for (int i = 0; i < 40; ++i) {
    const FusedPose best = robot.best(i, i);
    const FusedPose now = continuous.next(best, i > 0 ? std::optional(robot.best(i - 1, i)) : std::nullopt);
    const Eigen::Vector3d step = now.T_frame_body.translation() - last.translation();
    if (i > 0) {
      EXPECT_NEAR(step.x(), 0.5 * kPeriodS, 1e-9) << "the motion itself is not held back";
      EXPECT_LE(std::abs(step.y()), params.max_mps * kPeriodS + 1e-9);
    }
    // What is left stands in the covariance.
    const double left = best.T_frame_body.translation().y() - now.T_frame_body.translation().y();
    EXPECT_NEAR(now.covariance(1, 1), left * left, 1e-12);
    last = now.T_frame_body;
    if (i == 10 + 15) {
      EXPECT_NEAR(last.translation().y(), robot.off_m, 0.06 * robot.off_m) << "0.3 s later";
    }
  }
}

TEST(ContinuousPose, ALargeCorrectionIsHeldToItsSpeed) {
  const BlendParams params;
  const Corrected robot{1.0};
  ContinuousPose continuous(params);
  double last = 0, longest = 0;
  for (int i = 0; i < 600; ++i) {
    const FusedPose now = continuous.next(robot.best(i, i), i > 0 ? std::optional(robot.best(i - 1, i)) : std::nullopt);
    longest = std::max(longest, std::abs(now.T_frame_body.translation().y() - last));
    last = now.T_frame_body.translation().y();
  }
  EXPECT_LE(longest, params.max_mps * kPeriodS + 1e-9);
  EXPECT_NEAR(last, 1.0, 1e-3);
}

TEST(ContinuousPose, AnotherFrameAndTheEndOfALossAreTakenAtOnce) {
  ContinuousPose continuous({});
  (void)continuous.next(pose(0, {}), std::nullopt);
  FusedPose world = pose(1, {5, 5, 1});
  world.frame = Frame::kWorld;
  FusedPose world_before = pose(0, {5, 5, 1});
  world_before.frame = Frame::kWorld;
  EXPECT_EQ(continuous.next(world, world_before).T_frame_body.matrix(), world.T_frame_body.matrix());
  FusedPose lost = world;
  lost.stamp += from_seconds(kPeriodS);
  lost.status = Status::kLost;
  (void)continuous.next(lost, world);
  FusedPose found = pose(3, {6, 5, 1}), found_before = pose(2, {6, 5, 1});
  found.frame = found_before.frame = Frame::kWorld;
  EXPECT_EQ(continuous.next(found, found_before).T_frame_body.matrix(), found.T_frame_body.matrix());
}

}  // namespace
}  // namespace arpent::fusion
