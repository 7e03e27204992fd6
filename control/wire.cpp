// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/wire.h"

#include <cmath>

#include "common/geometry.h"
#include "common/pose2.h"

namespace arpent::control {
namespace {

constexpr double kMaxPositionM = 1e6;
constexpr double kMaxSpeedMps = 100;
constexpr double kMaxRateRadps = 100;
/// Bounds the memory that a path takes when it is resampled.
constexpr double kMaxLengthM = 5000;

/// NaN is not within.
bool within(double value, double most) {
  return std::abs(value) <= most;
}

bool known_frame(const std::string& frame) {
  return frame == "world" || frame == "odom";
}

}  // namespace

Result<TrackedPose> from_wire(const body_pose_t& message) {
  if (!known_frame(message.frame) || message.child_frame != "body")
    return Fault{"frames are not world or odom and body"};
  if (message.status < body_pose_t::STATUS_OK || message.status > body_pose_t::STATUS_LOST) {
    return Fault{"unknown status"};
  }
  const double* q = message.orientation_wxyz;
  const auto pose = make_pose(Eigen::Map<const Eigen::Vector3d>(message.position_m), {q[0], q[1], q[2], q[3]});
  if (!pose || !within(pose->translation().lpNorm<Eigen::Infinity>(), kMaxPositionM)) {
    return Fault{"the pose is not a rigid motion nearby"};
  }
  if (!within(message.velocity_mps[0], kMaxSpeedMps) || !within(message.angular_velocity_radps[2], kMaxRateRadps)) {
    return Fault{"the velocity is none of a robot"};
  }
  TrackedPose tracked;
  const Pose2 on_ground = to_pose2(*pose);
  tracked.state.stamp = from_utime(message.utime);
  tracked.state.p_map_m = on_ground.position_m();
  tracked.state.yaw_rad = on_ground.yaw_rad;
  tracked.state.twist = {message.velocity_mps[0], message.angular_velocity_radps[2]};
  tracked.frame = message.frame;
  tracked.lost = message.status == body_pose_t::STATUS_LOST;
  tracked.reason = message.reason;
  return tracked;
}

Result<PathOrder> from_wire(const path_t& message) {
  if (!known_frame(message.frame)) return Fault{"its frame is neither world nor odom"};
  PathOrder order;
  order.stamp = from_utime(message.utime);
  order.sequence = message.sequence;
  order.frame = message.frame;
  double length_m = 0;
  for (std::size_t i = 0; i < message.x_m.size(); ++i) {
    if (!within(message.x_m[i], kMaxPositionM) || !within(message.y_m[i], kMaxPositionM)) {
      return Fault{"a point is not on this ground"};
    }
    order.points_m.emplace_back(message.x_m[i], message.y_m[i]);
    if (i > 0) length_m += (order.points_m[i] - order.points_m[i - 1]).norm();
  }
  if (length_m > kMaxLengthM) return Fault{"it is longer than 5 km"};
  order.backwards = message.backwards != 0;
  if (message.has_goal_heading != 0) {
    if (!within(message.goal_heading_rad, 100)) return Fault{"its goal heading is not an angle"};
    order.goal_heading_rad = message.goal_heading_rad;
  }
  if (!(message.max_speed_mps >= 0)) return Fault{"its speed is not >= 0"};
  if (message.max_speed_mps > 0) order.max_speed_mps = message.max_speed_mps;
  return order;
}

std::string find_hindrance(const wheel_state_t& message) {
  if (message.emergency_button != 0) return "the emergency button is pressed";
  if (message.gate == wheel_state_t::GATE_STOPPED) return "the emergency stop is latched";
  if (message.gate != wheel_state_t::GATE_ARMED) return "the base is not armed";
  if (message.remote_control != 0) return "the transmitter has the base";
  if (message.heard == 0) return "the chassis is silent";
  return "";
}

wheel_command_t to_wire(const Twist2& command, Time pose_stamp) {
  wheel_command_t message{};
  message.utime = to_utime(pose_stamp);
  message.speed_mps = command.speed_mps;
  message.turn_rate_radps = command.turn_rate_radps;
  return message;
}

tracker_status_t to_wire(const TrackerOutput& output, Time pose_stamp, std::int64_t path_sequence) {
  static_assert(static_cast<int>(TrackerMode::kIdle) == 0 && static_cast<int>(TrackerMode::kBrake) == 5);
  tracker_status_t message{};
  message.utime = to_utime(pose_stamp);
  message.path_sequence = path_sequence;
  message.mode = static_cast<std::int8_t>(output.mode);
  message.cross_track_m = output.cross_track_m;
  message.remaining_m = output.remaining_m;
  message.reason = output.reason;
  return message;
}

}  // namespace arpent::control
