// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The motion of a base over one short interval, from wheels and gyro, with its Jacobian and noise: what the filter
// (motion_filter.h) predicts with.
#pragma once

#include "perception/fusion/motion_filter.h"

namespace arpent::fusion {

/// What the motion depends on and the filter estimates.
struct Estimated {
  double gyro_bias_radps = 0;
  double distance_scale = 0;
  double turn_scale = 0;
  Twist2 held;  ///< the motion where neither wheels nor gyro say one
};

struct MotionStep {
  Pose T_before_after = Pose::Identity();
  MotionCovariance F = MotionCovariance::Identity();
  MotionCovariance Q = MotionCovariance::Zero();
  Twist2 twist;
  double ground_keep = 1;  ///< share of roll, pitch and height that stays
};

/// An arc. Without `use_wheels` the speed is the held one; without a gyro the turn is the wheels', or the held one.
[[nodiscard]] MotionStep make_motion_step(const Interval& interval, const Estimated& estimated, bool use_wheels,
                                          const FusionParams& params);
/// The base stands: no motion, no noise.
[[nodiscard]] MotionStep standing_step(const Interval& interval, const FusionParams& params);

/// Roll, pitch and height scaled by `keep`; position and heading on the plane stay.
[[nodiscard]] Pose revert_to_ground(const Pose& T_frame_body, double keep);

void apply(const MotionStep& step, MotionCovariance& covariance);
/// Propagates the cross-covariance with the clone as well.
void apply(const MotionStep& step, StateCovariance& P);

}  // namespace arpent::fusion
