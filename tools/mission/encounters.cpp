// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/encounters.h"

#include <algorithm>
#include <optional>

#include "common/ellipse.h"
#include "common/pose2.h"
#include "planning/local/obstacles.h"

namespace arpent::tools {
namespace {

using evaluation::Trajectory;

/// Where a robot was; asked for ascending times.
class Way {
 public:
  explicit Way(const Trajectory& truth) : truth_(truth) {}

  /// nullopt before its beginning and after its end.
  [[nodiscard]] std::optional<Pose2> at(Time time) {
    while (next_ < truth_.size() && truth_[next_].stamp < time) ++next_;
    if (next_ == truth_.size()) return std::nullopt;
    const auto& to = truth_[next_];
    if (to.stamp == time) return to_pose2(to.T_ref_body);
    if (next_ == 0) return std::nullopt;
    const auto& from = truth_[next_ - 1];
    const double share = to_seconds(time - from.stamp) / to_seconds(to.stamp - from.stamp);
    return to_pose2(interpolate(from.T_ref_body, to.T_ref_body, share));
  }

 private:
  const Trajectory& truth_;
  std::size_t next_ = 0;
};

void compare(const RobotConfig& robot, const Trajectory& a, const Trajectory& b, TeamEncounters& encounters) {
  const planning::Footprint footprint({robot.semi_axis_long_m, robot.semi_axis_short_m});
  Way way(b);
  bool together = false;
  for (const auto& pose : a) {
    const std::optional<Pose2> other = way.at(pose.stamp);
    if (!other) continue;
    const Pose2 own = to_pose2(pose.T_ref_body);
    encounters.least_gap_m = std::min(encounters.least_gap_m, planning::gap_m(footprint, own, *other));
    const bool overlap = ellipses_overlap(robot.semi_axis_long_m, robot.semi_axis_short_m, own, *other);
    encounters.overlaps += overlap && !together ? 1 : 0;
    together = overlap;
  }
}

}  // namespace

TeamEncounters encounters_of(const RobotConfig& robot, const std::vector<Trajectory>& truths) {
  TeamEncounters encounters;
  for (std::size_t a = 0; a < truths.size(); ++a) {
    for (std::size_t b = a + 1; b < truths.size(); ++b) compare(robot, truths[a], truths[b], encounters);
  }
  return encounters;
}

}  // namespace arpent::tools
