// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of a team: robot_state_t, tour_t, tour_report_t. Conversions from the wire check names, numbers
// and counts.
#pragma once

#include <arpent/robot_state_t.hpp>
#include <arpent/tour_report_t.hpp>
#include <arpent/tour_t.hpp>

#include "common/result.h"
#include "planning/team/types.h"

namespace arpent::planning {

[[nodiscard]] robot_state_t to_wire(const RobotState& state);
[[nodiscard]] Result<RobotState> from_wire(const robot_state_t& message);

/// Elements farther than 32767 voxels from their viewpoint's first are left out.
[[nodiscard]] tour_t to_wire(const TeamTour& tour);
[[nodiscard]] Result<TeamTour> from_wire(const tour_t& message);

[[nodiscard]] tour_report_t to_wire(const TourReport& report);
[[nodiscard]] Result<TourReport> from_wire(const tour_report_t& message);

}  // namespace arpent::planning
