// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/leg_planner.h"

#include <algorithm>
#include <cmath>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::planning {
namespace {

/// The field of costs is known this much farther than the start: detours up to it are considered.
constexpr double kDetourM = 3.0;
/// What happens farther from the way than this does not change it.
constexpr double kRegionMarginM = 1.0;
constexpr double kSamePlaceM = 1e-3;

/// Whether the ground under the ellipse is unknown somewhere.
bool stands_on_unknown(const Ground& ground, const Pose2& pose) {
  const double step = ground.frame().cell_m;
  const double reach = ground.footprint().long_m();
  for (double dx = -reach; dx <= reach; dx += step) {
    for (double dy = -reach; dy <= reach; dy += step) {
      const Eigen::Vector2d p(pose.x_m + dx, pose.y_m + dy);
      if (ground.footprint().contains(pose, p) && ground.state(p) == CellState::kUnknown) return true;
    }
  }
  return false;
}

GroundBox box_around(const std::vector<Eigen::Vector2d>& points, double margin_m) {
  GroundBox box{points.front(), points.front()};
  for (const Eigen::Vector2d& p : points) {
    box.least_m = box.least_m.cwiseMin(p);
    box.most_m = box.most_m.cwiseMax(p);
  }
  box.least_m.array() -= margin_m;
  box.most_m.array() += margin_m;
  return box;
}

/// Around everything that the sweep from the goal reached: a way to it can open nowhere else.
GroundBox box_reached(const Ground& ground, const Sweep& to_goal, const Pose2& goal) {
  GroundBox box{goal.position_m(), goal.position_m()};
  for (std::size_t at = 0; at < to_goal.costs().size(); ++at) {
    if (to_goal.costs()[at] == Sweep::kNotReached) continue;
    box.least_m = box.least_m.cwiseMin(ground.frame().centre_m(at));
    box.most_m = box.most_m.cwiseMax(ground.frame().centre_m(at));
  }
  const double reach_m = ground.footprint().short_m() + 2 * ground.frame().cell_m;
  box.least_m.array() -= reach_m;
  box.most_m.array() += reach_m;
  return box;
}

LegResult no_leg(NoLeg reason, const GroundBox& region, int steps = 0) {
  LegResult result;
  result.reason = reason;
  result.region = region;
  result.steps = steps;
  return result;
}

bool finite(const Pose2& pose) {
  return std::isfinite(pose.x_m) && std::isfinite(pose.y_m) && std::isfinite(pose.yaw_rad);
}

}  // namespace

const char* to_text(NoLeg reason) {
  switch (reason) {
    case NoLeg::kStartUnknown:
      return "the robot stands on ground that was never seen";
    case NoLeg::kStartBlocked:
      return "the robot stands too close to an obstacle";
    case NoLeg::kGoalUnknown:
      return "the goal lies on ground that was never seen";
    case NoLeg::kGoalBlocked:
      return "an obstacle is in the goal's footprint";
    case NoLeg::kNoWay:
      return "no way that is known to be free leads there";
    case NoLeg::kTooTight:
      return "the way is too tight for the footprint";
    case NoLeg::kBudget:
      return "the search used up its steps";
    case NoLeg::kStuck:
      return "the robot got stuck on the way there";
  }
  return "";
}

LegPlanner::LegPlanner(const LegPlannerParams& params) : params_(params) {
  config::check(params, "leg planner");
}

LegResult LegPlanner::plan(const Ground& ground, const Pose2& start, const Pose2& goal) const {
  ARPENT_ASSERT(finite(start) && finite(goal));
  const double reach_m = ground.footprint().long_m() + ground.frame().cell_m;
  const double start_margin = ground.margin_m(start);
  if (start_margin < -params_.start_slack_m) {
    return no_leg(stands_on_unknown(ground, start) ? NoLeg::kStartUnknown : NoLeg::kStartBlocked,
                  box_around({start.position_m()}, reach_m));
  }
  if (!ground.is_free(goal)) {
    return no_leg(stands_on_unknown(ground, goal) ? NoLeg::kGoalUnknown : NoLeg::kGoalBlocked,
                  box_around({goal.position_m()}, reach_m));
  }
  // Whoever touches a wall must swing a little deeper into it to turn away.
  const StartSlack slack{start_margin < 0 ? params_.start_slack_m : 0.0};
  LegResult result = search(ground, start, goal, slack);
  if (!result.leg) return result;
  // The last word: the whole leg, as it would be driven.
  if (first_contact(ground, result.leg->motions, slack)) {
    return no_leg(NoLeg::kTooTight, result.region, result.steps);
  }
  return result;
}

LegResult LegPlanner::search(const Ground& ground, const Pose2& start, const Pose2& goal,
                             const StartSlack& slack) const {
  LegResult result;
  result.region = box_around({start.position_m(), goal.position_m()}, kRegionMarginM);
  if ((start.position_m() - goal.position_m()).norm() < kSamePlaceM &&
      std::abs(wrap_angle(goal.yaw_rad - start.yaw_rad)) < kSamePlaceM) {
    result.leg = Leg{start, goal, {}, slack};
    return result;
  }
  const Sweep to_goal(ground, goal.position_m(), std::numeric_limits<double>::infinity(), start.position_m(), kDetourM);
  const auto way = to_goal.way_to(start.position_m());
  if (way.empty()) return no_leg(NoLeg::kNoWay, box_reached(ground, to_goal, goal));
  result.region = box_around(way, kRegionMarginM);
  if (params_.planner == "lazy_prm") {
    const LazyPrmResult found = plan_lazy_prm(ground, start, goal, params_.lazy_prm, slack);
    result.steps = found.samples;
    if (!found.motions) return no_leg(NoLeg::kBudget, result.region, found.samples);
    result.leg = Leg{start, goal, *found.motions, slack};
    return result;
  }
  const LatticeResult found = search_lattice(ground, start, goal, to_goal, params_.lattice, slack);
  result.steps = found.expansions;
  if (!found.motions) {
    return no_leg(found.out_of_budget ? NoLeg::kBudget : NoLeg::kTooTight, result.region, found.expansions);
  }
  result.leg = Leg{start, goal, shorten(ground, *found.motions, params_.lattice.turn_radius_m, slack), slack};
  return result;
}

}  // namespace arpent::planning
