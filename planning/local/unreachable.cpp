// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/unreachable.h"

#include <algorithm>
#include <cmath>

namespace arpent::planning {
namespace {

constexpr double kSamePlaceM = 0.05;
constexpr double kSameHeadingRad = 0.05;

bool contains(const GroundBox& box, const Eigen::Vector2d& p) {
  return (p.array() >= box.least_m.array()).all() && (p.array() <= box.most_m.array()).all();
}

/// Whether it may be different from another start on the same ground.
bool depends_on_start(NoLeg reason) {
  return reason == NoLeg::kTooTight || reason == NoLeg::kBudget;
}

}  // namespace

bool same_goal(const Pose2& a, const Pose2& b) {
  return (a.position_m() - b.position_m()).norm() <= kSamePlaceM &&
         std::abs(wrap_angle(a.yaw_rad - b.yaw_rad)) <= kSameHeadingRad;
}

void UnreachableGoals::remember(const Pose2& goal, const LegResult& failure, std::int64_t ground_revision) {
  if (failure.leg || failure.reason == NoLeg::kStartBlocked || failure.reason == NoLeg::kStartUnknown) return;
  std::erase_if(goals_, [&](const UnreachableGoal& held) { return same_goal(held.goal, goal); });
  goals_.push_back({goal, failure.reason, failure.region, ground_revision});
}

std::optional<NoLeg> UnreachableGoals::find(const Pose2& goal, const Pose2& start, const GroundGrid& grid) const {
  const auto held = std::find_if(goals_.begin(), goals_.end(), [&](const auto& g) { return same_goal(g.goal, goal); });
  if (held == goals_.end() || grid.changed_since(held->region, held->revision)) return std::nullopt;
  // A start that came over to the goal's side of a closed door is reached without any change.
  const bool inside = contains(held->region, start.position_m());
  if (depends_on_start(held->reason) && !inside) return std::nullopt;
  if (held->reason == NoLeg::kNoWay && inside) return std::nullopt;
  return held->reason;
}

}  // namespace arpent::planning
