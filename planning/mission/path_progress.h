// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What is left of a path that was broken off.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace arpent::planning {

[[nodiscard]] double length_m(const std::vector<Eigen::Vector2d>& points_m);

/// The path from arc length `driven_m` on, reached from `from_m` in a straight line.
[[nodiscard]] std::vector<Eigen::Vector2d> rest_of(const std::vector<Eigen::Vector2d>& points_m, double driven_m,
                                                   const Eigen::Vector2d& from_m);

}  // namespace arpent::planning
