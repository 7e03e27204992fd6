// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a team under one plan tells each other (thesis Ch. 3): robots their state and what became of their viewpoints,
// the centre their tours.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/time.h"
#include "common/twist2.h"
#include "planning/mission/explorer.h"
#include "planning/mission/lifecycle.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

struct RobotState {
  Time stamp;  ///< the robot's clock
  std::string robot;
  MissionState state = MissionState::kWaiting;
  Pose2 body;  ///< in the common frame
  Twist2 twist;
  double position_sigma_m = 0;
  std::int64_t tour = -1;  ///< in force
  bool idle = true;
  std::optional<Pose2> target;          ///< viewpoint that it is on its way to, or looks from
  std::string blocked_by;               ///< teammate in its way; empty: none
  std::vector<Eigen::Vector2d> path_m;  ///< the next few metres of its way
};

struct TeamTour {
  Time stamp;  ///< the centre's clock
  std::int64_t number = 0;
  std::string robot;
  Time state_stamp;  ///< of the robot's newest state that it was planned from
  double valid_s = 3;
  std::int64_t samples_below = 0;  ///< all of the robot's patches below this sequence have come
  bool done = false;               ///< nothing is left that the team could complete
  std::vector<Viewpoint> viewpoints;
};

struct TourReport {
  Time stamp;
  std::string robot;
  TargetEvent event;
};

}  // namespace arpent::planning
