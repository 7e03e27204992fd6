// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/aside.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arpent::planning {
namespace {

constexpr int kDirections = 16;
constexpr double kStepM = 0.25;
constexpr double kMostM = 3.0;

bool is_clear(const Eigen::Vector2d& p, const std::vector<Eigen::Vector2d>& way_m, double clear_m) {
  return std::all_of(way_m.begin(), way_m.end(), [&](const auto& q) { return (p - q).norm() >= clear_m; });
}

}  // namespace

std::optional<Leg> find_way_aside(const Ground& ground, const LegPlanner& planner, const Pose2& robot,
                                  const std::vector<Eigen::Vector2d>& way_m, double clear_m) {
  if (is_clear(robot.position_m(), way_m, clear_m)) return std::nullopt;
  for (double r = kStepM; r <= kMostM; r += kStepM) {
    for (int i = 0; i < kDirections; ++i) {
      const double bearing = robot.yaw_rad + i * 2 * std::numbers::pi / kDirections;
      const Pose2 aside{robot.x_m + r * std::cos(bearing), robot.y_m + r * std::sin(bearing), wrap_angle(bearing)};
      if (!is_clear(aside.position_m(), way_m, clear_m) || !ground.is_free(aside)) continue;
      if (LegResult result = planner.plan(ground, robot, aside); result.leg) return std::move(result.leg);
    }
  }
  return std::nullopt;
}

}  // namespace arpent::planning
