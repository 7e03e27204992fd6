// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/robot/sim_robot.h"

#include <cmath>

namespace arpent::sim {

Pose2 move_along_arc(const Pose2& from, const Twist2& twist, double duration_s) {
  const double turned = twist.turn_rate_radps * duration_s;
  // The chord of the arc: its length by sinc, its direction half way between the headings.
  const double half = 0.5 * turned;
  const double sinc = std::abs(half) < 1e-6 ? 1 - half * half / 6 : std::sin(half) / half;
  const double chord_m = twist.speed_mps * duration_s * sinc;
  return {from.x_m + chord_m * std::cos(from.yaw_rad + half), from.y_m + chord_m * std::sin(from.yaw_rad + half),
          wrap_angle(from.yaw_rad + turned)};
}

void SimRobot::step(const Twist2& pushed, double duration_s) {
  const Pose2 next = move_along_arc(pose_, pushed, duration_s);
  const bool moves = pushed.speed_mps != 0 || pushed.turn_rate_radps != 0;
  const bool touches = moves && touches_(next);
  if (touches && !in_contact_) ++collisions_;
  in_contact_ = touches || (!moves && in_contact_);
  twist_ = touches ? Twist2{} : pushed;
  if (touches) return;
  driven_m_ += (next.position_m() - pose_.position_m()).norm();
  pose_ = next;
}

}  // namespace arpent::sim
