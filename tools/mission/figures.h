// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a mission was worth, in figures (DESIGN section 6): time, way, errors of the pose against the truth, without any
// alignment but the robot's own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/mission/run.h"

namespace arpent::tools {

/// From these on the base drives or turns (DESIGN section 6).
inline constexpr double kDrivingMps = 0.2;
inline constexpr double kTurningRadps = 0.5;

struct MissionFigures {
  double time_s = 0;  ///< from the start to the end, aligning included
  double path_m = 0;  ///< true way
  double duty_cycle_percent = 0;
  double ate_m = 0;  ///< root mean square of the position error, world frame, no alignment
  double worst_error_m = 0;
  double yaw_error_deg = 0;  ///< root mean square
  double off_path_m = 0;     ///< root mean square of the true distance from the planned path
  double worst_off_path_m = 0;
  double realtime_factor = 0;  ///< simulated time over CPU time; 0 if live
  int collisions = 0;
  int estops = 0;
  std::vector<evaluation::StampedPose> estimate;  ///< with its errors:
  std::vector<double> error_m, yaw_error_rad;
};

[[nodiscard]] MissionFigures measure(const MissionResult& result);

/// Share [%] of the time between the first and the last command in which the base drives (|v| >= 0.2 m/s) or turns
/// (|w| >= 0.5 rad/s).
[[nodiscard]] double duty_cycle_percent(const std::vector<StampedTwist>& commands);

/// report.html, truth.tum, estimate.tum, mesh.ply and mission.json in `folder`.
void write_mission_report(const std::filesystem::path& folder, const MissionSpec& spec, const MissionResult& result,
                          const MissionFigures& figures);
void print(const MissionFigures& figures, const MissionResult& result);
/// Says where the report is, and, as `program`, what the log lacks. The exit code: 0 done, 1 not done or not all on
/// disk.
[[nodiscard]] int conclude(const char* program, const std::filesystem::path& folder, bool done,
                           const std::string& log_fault);

}  // namespace arpent::tools
