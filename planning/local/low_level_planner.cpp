// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/low_level_planner.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "common/config/config.h"

namespace arpent::planning {
namespace {

/// A goal nearer than this is turned to where the robot stands: a robot that only drives forwards would have to drive a
/// loop to it.
constexpr double kSamePlaceM = 0.15;
constexpr double kSameHeadingRad = 0.01;

/// As far as the leg is driven without a stop: to its first turn on the spot, or its end.
double first_drive_m(const Leg& leg) {
  double driven_m = 0;
  for (const Motion& motion : leg.motions) {
    if (motion.is_turn()) break;
    driven_m += motion.length_m;
  }
  return driven_m;
}

bool leads_to(const Leg& leg, const Pose2& goal) {
  return (leg.goal.position_m() - goal.position_m()).norm() < kSamePlaceM &&
         std::abs(wrap_angle(leg.goal.yaw_rad - goal.yaw_rad)) < kSameHeadingRad;
}

}  // namespace

const char* to_text(ReplanReason reason) {
  switch (reason) {
    case ReplanReason::kNone:
      return "the tour goes on";
    case ReplanReason::kNoTour:
      return "there is no tour";
    case ReplanReason::kTourDone:
      return "the tour's last target was visited";
    case ReplanReason::kUtility:
      return "most of what the tour set out to complete is complete";
    case ReplanReason::kObstacle:
      return "an obstacle blocks the leg";
    case ReplanReason::kNothingReachable:
      return "no target that is left can be reached";
  }
  return "";
}

LowLevelPlanner::LowLevelPlanner(const LowLevelParams& params) : params_(params), planner_(params.leg) {
  config::check(params, "low-level planner");
}

void LowLevelPlanner::set_tour(Tour tour) {
  tour_ = std::move(tour);
  next_ = 0;
  completed_share_ = 0;
  waiting_for_ = tour_.targets.empty() ? ReplanReason::kNoTour : ReplanReason::kNone;
  if (driving_ && (tour_.targets.empty() || !leads_to(driving_->leg, tour_.targets.front().pose))) driving_.reset();
}

void LowLevelPlanner::set_incomplete(std::span<const mapping::VoxelIndex> elements) {
  if (tour_.elements.empty()) return;
  using Key = std::tuple<int, int, int>;
  const auto key = [](const mapping::VoxelIndex& v) { return Key(v.x(), v.y(), v.z()); };
  std::set<Key> incomplete;
  for (const mapping::VoxelIndex& v : elements) incomplete.insert(key(v));
  const auto open = std::count_if(tour_.elements.begin(), tour_.elements.end(),
                                  [&](const auto& v) { return incomplete.contains(key(v)); });
  completed_share_ = 1 - static_cast<double>(open) / static_cast<double>(tour_.elements.size());
}

std::optional<TourTarget> LowLevelPlanner::target() const {
  if (!driving_ || next_ >= tour_.targets.size()) return std::nullopt;
  return tour_.targets[next_];
}

LowLevelOutput LowLevelPlanner::step(const LowLevelInput& input) {
  LowLevelOutput output;
  const bool was_driving = driving_.has_value();
  if (input.traffic == TrafficAdvice::kYield) {
    // The way is looked for anew when it is clear again.
    driving_.reset();
  } else {
    if (driving_) drive(input, output);
    // Where a target is reached there is something to look at first.
    if (!driving_ && !output.visited && waiting_for_ == ReplanReason::kNone) begin_next_leg(input, output);
  }
  output.replan = waiting_for_;
  if (output.order != DriveOrder::kFollow && !output.visited && !driving_ && (was_driving || !standing_)) {
    // An arrived robot stands by itself; to say it again does no harm.
    output.order = DriveOrder::kStop;
  }
  standing_ = !driving_;
  return output;
}

/// On a leg: GoalReached, ObstacleCheck, UtilityCheck.
void LowLevelPlanner::drive(const LowLevelInput& input, LowLevelOutput& output) {
  driving_->progress.advance(input.pose);
  if (reached(input.pose)) {
    output.visited = tour_.targets[next_].id;
    ++next_;
    driving_.reset();
    return;
  }
  if (params_.judge_while_driving && completed_share_ >= params_.completed_share) {
    // The leg goes on until the new tour is there: thinking costs no standing.
    waiting_for_ = ReplanReason::kUtility;
  }
  const StartSlack slack{std::max(params_.obstacle_depth_m, driving_->leg.slack.depth_m),
                         driving_->leg.slack.depth_m > params_.obstacle_depth_m ? driving_->leg.slack.along_m : 1e9};
  const bool blocked =
      first_contact(input.ground, driving_->leg.motions, slack, driving_->progress.place()).has_value();
  const bool lost = driving_->progress.off_m() > params_.max_off_leg_m;
  if (!blocked && !lost) return;
  driving_.reset();
  if ((lost || params_.bypass_obstacles) && try_leg(input, tour_.targets[next_], output)) return;
  // An obstacle's stop is no visit: the target stays open for the next tour.
  waiting_for_ = ReplanReason::kObstacle;
}

/// Between legs: UtilityCheck, then the first target to which a leg leads.
void LowLevelPlanner::begin_next_leg(const LowLevelInput& input, LowLevelOutput& output) {
  if (completed_share_ >= params_.completed_share) {
    waiting_for_ = ReplanReason::kUtility;
    return;
  }
  const bool all_visited = next_ >= tour_.targets.size();
  for (; next_ < tour_.targets.size(); ++next_) {
    if (try_leg(input, tour_.targets[next_], output)) return;
  }
  waiting_for_ = all_visited ? ReplanReason::kTourDone : ReplanReason::kNothingReachable;
}

void LowLevelPlanner::give_up_target(const LowLevelInput& input) {
  if (const auto stuck_on = target()) {
    const Eigen::Vector2d reach = Eigen::Vector2d::Constant(input.ground.footprint().long_m());
    LegResult failure;
    failure.reason = NoLeg::kStuck;
    failure.region = {input.pose.position_m() - reach, input.pose.position_m() + reach};
    unreachable_.remember(stuck_on->pose, failure, input.grid.revision());
  }
  set_tour({});
}

bool LowLevelPlanner::reached(const Pose2& pose) const {
  const Pose2& goal = driving_->leg.goal;
  return (goal.position_m() - pose.position_m()).norm() <= params_.goal_tolerance_m &&
         std::abs(wrap_angle(goal.yaw_rad - pose.yaw_rad)) <= params_.goal_tolerance_rad;
}

/// A robot that drives would stop, and turn, farther ahead than the leg does, where nobody has looked for room.
bool LowLevelPlanner::overshoots(const Leg& leg, double speed_mps) const {
  return std::abs(speed_mps) > kStandsMps &&
         first_drive_m(leg) < speed_mps * speed_mps / (2 * params_.deceleration_mps2);
}

bool LowLevelPlanner::try_leg(const LowLevelInput& input, const TourTarget& target, LowLevelOutput& output) {
  if (const auto known = unreachable_.find(target.pose, input.pose, input.grid)) {
    output.skipped.push_back({target.id, *known});
    return false;
  }
  const bool here = (target.pose.position_m() - input.pose.position_m()).norm() < kSamePlaceM;
  const Pose2 goal = here ? Pose2{input.pose.x_m, input.pose.y_m, target.pose.yaw_rad} : target.pose;
  LegResult result = planner_.plan(input.ground, input.pose, goal);
  if (!result.leg) {
    unreachable_.remember(target.pose, result, input.grid.revision());
    output.skipped.push_back({target.id, result.reason});
    return false;
  }
  if (overshoots(*result.leg, input.speed_mps)) return true;  // it stops, and looks again
  LegProgress progress(*result.leg);
  output.order = DriveOrder::kFollow;
  output.leg = *result.leg;
  driving_.emplace(Driving{std::move(*result.leg), std::move(progress)});
  return true;
}

}  // namespace arpent::planning
