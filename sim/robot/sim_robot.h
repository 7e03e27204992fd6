// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A body that drives on the ground of a world: it goes where its wheels push it until it touches something, and then
// stands. The chassis (drivers/base) says how the wheels push, the world (sim/world) what there is to touch.
#pragma once

#include <functional>

#include "common/pose2.h"
#include "common/twist2.h"

namespace arpent::sim {

class SimRobot {
 public:
  /// Whether the body, standing at a pose, touches the world or a teammate.
  using TouchTest = std::function<bool(const Pose2&)>;

  SimRobot(const Pose2& start, TouchTest touches) : pose_(start), touches_(std::move(touches)) {}

  /// Moves along the arc of `pushed` for `duration_s`. A step that would touch is not taken: the body stands instead,
  /// and each time that this begins counts as one collision.
  void step(const Twist2& pushed, double duration_s);

  [[nodiscard]] const Pose2& pose() const { return pose_; }
  /// Over ground, in the last step.
  [[nodiscard]] const Twist2& twist() const { return twist_; }
  [[nodiscard]] bool in_contact() const { return in_contact_; }
  [[nodiscard]] int collisions() const { return collisions_; }
  [[nodiscard]] double driven_m() const { return driven_m_; }

 private:
  Pose2 pose_;
  TouchTest touches_;
  Twist2 twist_;
  bool in_contact_ = false;
  int collisions_ = 0;
  double driven_m_ = 0;
};

/// Where a body that moves with `twist` for `duration_s` gets to: exact on the arc.
[[nodiscard]] Pose2 move_along_arc(const Pose2& from, const Twist2& twist, double duration_s);

}  // namespace arpent::sim
