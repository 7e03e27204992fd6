// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/fusion/continuous_pose.h"

#include <algorithm>
#include <cmath>

namespace arpent::fusion {
namespace {

/// How much of a distance is closed: the exponential's share, but no more than the limit allows.
double closed_share(double distance, double share, double most) {
  return distance * share <= most ? share : most / distance;
}

}  // namespace

std::optional<Time> ContinuousPose::last_stamp() const {
  return last_ ? std::optional(last_->stamp) : std::nullopt;
}

FusedPose ContinuousPose::next(const FusedPose& best, const std::optional<FusedPose>& best_of_last) {
  FusedPose pose = best;
  // While lost nobody moves by this pose: it may come back where it belongs.
  if (last_ && best_of_last && last_->frame == best.frame && best_of_last->frame == best.frame &&
      last_->status != Status::kLost) {
    const Pose T_last_now = best_of_last->T_frame_body.inverse() * best.T_frame_body;
    const Pose moved = last_->T_frame_body * T_last_now;
    Vector6d left = local(moved, best.T_frame_body);
    const double duration_s = to_seconds(best.stamp - last_->stamp);
    const double share = 1 - std::exp(-duration_s / params_.time_s);
    Vector6d step = left;
    step.head<3>() *= closed_share(left.head<3>().norm(), share, params_.max_mps * duration_s);
    step.tail<3>() *= closed_share(left.tail<3>().norm(), share, params_.max_radps * duration_s);
    pose.T_frame_body = retract(moved, step);
    left = local(pose.T_frame_body, best.T_frame_body);
    pose.covariance += left * left.transpose();
  }
  last_ = pose;
  return pose;
}

}  // namespace arpent::fusion
