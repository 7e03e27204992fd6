// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Goals to which no leg was found, with the reason, so that they are not asked for again before something changed that
// could make a difference.
#pragma once

#include <optional>
#include <vector>

#include "planning/local/leg_planner.h"

namespace arpent::planning {

/// To within 5 cm and 0.05 rad.
[[nodiscard]] bool same_goal(const Pose2& a, const Pose2& b);

struct UnreachableGoal {
  Pose2 goal;
  NoLeg reason = NoLeg::kNoWay;
  GroundBox region;           ///< what the failure depended on
  std::int64_t revision = 0;  ///< of the ground at that time
};

class UnreachableGoals {
 public:
  /// Takes note of a failure; one that only concerns the start says nothing about the goal and is left out. Replaces
  /// what was known about the same place.
  void remember(const Pose2& goal, const LegResult& failure, std::int64_t ground_revision);
  /// The note on this goal (to within 5 cm and 0.05 rad) if it still holds: nothing changed in its region since, and
  /// `start` lies within the region or the failure does not depend on the start.
  [[nodiscard]] std::optional<NoLeg> find(const Pose2& goal, const Pose2& start, const GroundGrid& grid) const;
  [[nodiscard]] const std::vector<UnreachableGoal>& all() const { return goals_; }
  void clear() { goals_.clear(); }

 private:
  std::vector<UnreachableGoal> goals_;
};

}  // namespace arpent::planning
