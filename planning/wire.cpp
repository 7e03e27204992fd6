// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/wire.h"

#include <cmath>

namespace arpent::planning {

path_t to_wire(const PathOrder& path) {
  path_t message{};
  message.utime = to_utime(path.stamp);
  message.sequence = path.sequence;
  message.frame = path.frame;
  for (const Eigen::Vector2d& p : path.points_m) {
    message.x_m.push_back(p.x());
    message.y_m.push_back(p.y());
  }
  message.count = static_cast<std::int32_t>(path.points_m.size());
  message.backwards = path.backwards ? 1 : 0;
  message.has_goal_heading = path.goal_heading_rad ? 1 : 0;
  message.goal_heading_rad = path.goal_heading_rad.value_or(0);
  message.max_speed_mps = path.max_speed_mps;
  return message;
}

Result<MissionOrder> from_wire(const mission_command_t& message) {
  if (message.command < mission_command_t::COMMAND_START || message.command > mission_command_t::COMMAND_ABORT) {
    return Fault{"unknown mission command"};
  }
  return MissionOrder{static_cast<MissionCommand>(message.command), message.source};
}

mission_command_t to_wire(Time stamp, const MissionOrder& order) {
  mission_command_t message{};
  message.utime = to_utime(stamp);
  message.command = static_cast<std::int8_t>(order.command);
  message.source = order.source;
  return message;
}

mission_state_t to_wire(const MissionReport& report) {
  mission_state_t message{};
  message.utime = to_utime(report.stamp);
  message.state = static_cast<std::int8_t>(report.state);
  message.progress = report.progress;
  message.left_s = report.left_s;
  message.activity = report.activity;
  message.reason = report.reason;
  return message;
}

Result<MissionReport> from_wire(const mission_state_t& message) {
  if (message.state < mission_state_t::STATE_WAITING || message.state > mission_state_t::STATE_ABORTED) {
    return Fault{"unknown mission state"};
  }
  if (!std::isfinite(message.progress) || !std::isfinite(message.left_s)) return Fault{"numbers that are not finite"};
  return MissionReport{from_utime(message.utime), static_cast<MissionState>(message.state),
                       message.progress,          message.left_s,
                       message.activity,          message.reason};
}

Result<DriveReport> from_wire(const tracker_status_t& message) {
  if (message.mode < tracker_status_t::MODE_IDLE || message.mode > tracker_status_t::MODE_BRAKE) {
    return Fault{"unknown mode of the tracker"};
  }
  if (!std::isfinite(message.remaining_m)) return Fault{"numbers that are not finite"};
  return DriveReport{from_utime(message.utime),
                     message.path_sequence,
                     message.mode == tracker_status_t::MODE_ARRIVED,
                     message.mode == tracker_status_t::MODE_BRAKE,
                     message.remaining_m,
                     message.reason};
}

Result<BaseState> from_wire(const wheel_state_t& message) {
  if (message.gate < wheel_state_t::GATE_DISARMED || message.gate > wheel_state_t::GATE_STOPPED) {
    return Fault{"unknown state of the gate"};
  }
  return static_cast<BaseState>(message.gate);
}

base_request_t request(Time stamp, std::int8_t action, const std::string& source) {
  base_request_t message{};
  message.utime = to_utime(stamp);
  message.action = action;
  message.source = source;
  return message;
}

}  // namespace arpent::planning
