// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The manoeuvre of a robot that stands in a teammate's way (thesis Alg. 3, Sect. 3.5.2): to the nearest place that
// leaves the way free.
#pragma once

#include <optional>
#include <vector>

#include "planning/local/leg_planner.h"

namespace arpent::planning {

/// The leg to the nearest free place, on rings about the robot, at least `clear_m` from each point of `way_m`; nullopt
/// if no leg leads to one within 3 m, or the robot stands clear of the way already.
[[nodiscard]] std::optional<Leg> find_way_aside(const Ground& ground, const LegPlanner& planner, const Pose2& robot,
                                                const std::vector<Eigen::Vector2d>& way_m, double clear_m);

}  // namespace arpent::planning
