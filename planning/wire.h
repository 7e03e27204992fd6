// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of planning: path_t, base_request_t and mission_state_t out, mission_command_t and what the base
// and the path tracker say of themselves in.
#pragma once

#include <arpent/base_request_t.hpp>
#include <arpent/mission_command_t.hpp>
#include <arpent/mission_state_t.hpp>
#include <arpent/path_t.hpp>
#include <arpent/tracker_status_t.hpp>
#include <arpent/wheel_state_t.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/geometry.h"
#include "common/result.h"
#include "common/time.h"
#include "planning/mission/lifecycle.h"

namespace arpent::planning {

/// A path to be driven; without points the base stops.
struct PathOrder {
  Time stamp;
  std::int64_t sequence = 0;
  std::string frame = "world";
  std::vector<Eigen::Vector2d> points_m;
  bool backwards = false;
  std::optional<double> goal_heading_rad;
  double max_speed_mps = 0;  ///< 0: the tracker's own limit
};

[[nodiscard]] path_t to_wire(const PathOrder& path);

struct MissionOrder {
  MissionCommand command = MissionCommand::kStart;
  std::string source;
};
[[nodiscard]] Result<MissionOrder> from_wire(const mission_command_t& message);
[[nodiscard]] mission_command_t to_wire(Time stamp, const MissionOrder& order);

/// Where a mission stands, for people.
struct MissionReport {
  Time stamp;
  MissionState state = MissionState::kWaiting;
  double progress = 0;  ///< 0 to 1
  double left_s = -1;   ///< negative: unknown
  std::string activity;
  std::string reason;
};
[[nodiscard]] mission_state_t to_wire(const MissionReport& report);
[[nodiscard]] Result<MissionReport> from_wire(const mission_state_t& message);

/// What the path tracker says: how far the path is driven.
struct DriveReport {
  Time stamp;
  std::int64_t path_sequence = -1;
  bool arrived = false;
  bool braking = false;
  double remaining_m = 0;
  std::string reason;
};
[[nodiscard]] Result<DriveReport> from_wire(const tracker_status_t& message);

enum class BaseState : std::int8_t { kDisarmed = 0, kArmed = 1, kStopped = 2 };
[[nodiscard]] Result<BaseState> from_wire(const wheel_state_t& message);

[[nodiscard]] base_request_t request(Time stamp, std::int8_t action, const std::string& source);

}  // namespace arpent::planning
