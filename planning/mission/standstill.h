// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How long a robot has not moved.
#pragma once

#include <cmath>

#include "common/pose2.h"
#include "common/time.h"

namespace arpent::planning {

class Standstill {
 public:
  /// The robot is there now. True if it has moved.
  bool note(Time now, const Pose2& pose) {
    const bool moved = (pose.position_m() - from_.position_m()).norm() > 0.02 ||
                       std::abs(wrap_angle(pose.yaw_rad - from_.yaw_rad)) > 0.05;
    if (!moved && since_ != Time{}) return false;
    since_ = now;
    from_ = pose;
    return true;
  }
  /// Counts from now on: it was just told to move.
  void begin(Time now) { since_ = now; }
  [[nodiscard]] Duration lasted(Time now) const { return now - since_; }

 private:
  Time since_{};
  Pose2 from_;
};

}  // namespace arpent::planning
