// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of path tracking: body_pose_t, path_t and wheel_state_t in, wheel_command_t and tracker_status_t
// out.
#pragma once

#include <arpent/body_pose_t.hpp>
#include <arpent/path_t.hpp>
#include <arpent/tracker_status_t.hpp>
#include <arpent/wheel_command_t.hpp>
#include <arpent/wheel_state_t.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/result.h"
#include "control/path_tracker.h"

namespace arpent::control {

/// What the tracker needs of a pose.
struct TrackedPose {
  BaseState state;
  std::string frame;  ///< "world" or "odom"
  bool lost = true;
  std::string reason;  ///< why not OK
};

/// A path as it was ordered; without points it is the order to stop.
struct PathOrder {
  Time stamp;
  std::int64_t sequence = 0;
  std::string frame;
  std::vector<Eigen::Vector2d> points_m;
  bool backwards = false;
  std::optional<double> goal_heading_rad;
  std::optional<double> max_speed_mps;
};

[[nodiscard]] Result<TrackedPose> from_wire(const body_pose_t& message);
/// Checks the frame, finiteness, and that the path has a length of at most 5 km.
[[nodiscard]] Result<PathOrder> from_wire(const path_t& message);
/// Why the base would not move if told to, empty if it would.
[[nodiscard]] std::string find_hindrance(const wheel_state_t& message);

[[nodiscard]] wheel_command_t to_wire(const Twist2& command, Time pose_stamp);
/// `path_sequence`: -1 if none is followed.
[[nodiscard]] tracker_status_t to_wire(const TrackerOutput& output, Time pose_stamp, std::int64_t path_sequence);

}  // namespace arpent::control
