// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/obstacles.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arpent::planning {
namespace {

constexpr int kUnknownRing = 2;

void stamp(const GridFrame& frame, std::vector<CellState>& states, const Footprint& footprint, const Pose2& body,
           double grow_m, const Footprint& own_footprint, const Pose2& own) {
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(footprint.long_m() + grow_m);
  const Eigen::Vector2i least = frame.cell_of(body.position_m() - reach);
  const Eigen::Vector2i most = frame.cell_of(body.position_m() + reach);
  for (int j = std::max(kUnknownRing, least.y()); j <= std::min(frame.rows - 1 - kUnknownRing, most.y()); ++j) {
    for (int i = std::max(kUnknownRing, least.x()); i <= std::min(frame.cols - 1 - kUnknownRing, most.x()); ++i) {
      const Eigen::Vector2d p = frame.centre_m(i, j);
      if (!footprint.contains(body, p, grow_m) || own_footprint.contains(own, p)) continue;
      states[frame.at(i, j)] = CellState::kOccupied;
    }
  }
}

}  // namespace

Ground ground_with_bodies(const GroundGrid& grid, const Footprint& footprint, const DriveCosts& costs,
                          std::span<const Pose2> bodies, const Footprint& of_bodies, double gap_m, const Pose2& own) {
  std::vector<CellState> states = grid.states();
  for (const Pose2& body : bodies) stamp(grid.frame(), states, of_bodies, body, gap_m, footprint, own);
  return Ground(grid.frame(), std::move(states), footprint, costs);
}

double gap_m(const Footprint& footprint, const Pose2& a, const Pose2& b) {
  const double apart_m = (a.position_m() - b.position_m()).norm();
  // Far from each other the discs would say much the same.
  if (apart_m > 4 * footprint.long_m()) return apart_m - 2 * footprint.long_m();
  const Eigen::Vector2d ahead_a(std::cos(a.yaw_rad), std::sin(a.yaw_rad));
  const Eigen::Vector2d ahead_b(std::cos(b.yaw_rad), std::sin(b.yaw_rad));
  double least = std::numeric_limits<double>::infinity();
  for (const FootprintDisc& p : footprint.discs()) {
    const Eigen::Vector2d centre = a.position_m() + p.along_m * ahead_a;
    for (const FootprintDisc& q : footprint.discs()) {
      const double d = (centre - b.position_m() - q.along_m * ahead_b).norm();
      least = std::min(least, d - p.radius_m - q.radius_m);
    }
  }
  return least;
}

}  // namespace arpent::planning
