// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The explorer in a team: the centre plans, teammates are in the way.
#include <algorithm>
#include <utility>

#include "planning/local/aside.h"
#include "planning/local/obstacles.h"
#include "planning/local/sweep.h"
#include "planning/mission/explorer_state.h"

namespace arpent::planning {
namespace {

/// A tour that teammates keep a robot from is tried again so often, so much later each time.
constexpr int kRetries = 5;
constexpr Duration kRetryAfter = std::chrono::milliseconds(800);
/// Standing without a tour for so long, a robot that is boxed in gets out by itself.
constexpr Duration kRecoverAfter = std::chrono::seconds(3);

}  // namespace

Ground Explorer::State::ground_now(const Pose2& pose) const {
  if (team.bodies.empty()) return Ground(grid, footprint, params.costs);
  return ground_with_bodies(grid, footprint, params.costs, team.bodies, body_footprint, params.body_gap_m, pose);
}

void Explorer::State::note_visit(const Viewpoint& viewpoint, Time now) {
  targets.note_visit(map, viewpoint);
  last_visit = Visit{viewpoint.pose, now};
  if (!params.led) return;
  team.events.push_back({TargetEvent::Kind::kVisited, viewpoint.pose});
}

/// What no way leads to is left out of the tour and reported, unless teammates may be what is in the way.
void Explorer::State::note_skipped(const LowLevelOutput& output) {
  if (output.skipped.empty() || (!team.bodies.empty() && team.retries < kRetries)) return;
  for (const SkippedTarget& skipped : output.skipped) {
    team.events.push_back({TargetEvent::Kind::kUnreachable, viewpoints[static_cast<std::size_t>(skipped.id)].pose});
    std::erase_if(tour.targets, [&](const TourTarget& t) { return t.id == skipped.id; });
  }
  team.retries = 0;
}

/// Teammates do not count: robots that start side by side would look nowhere. Who turns first is traffic's matter.
bool Explorer::State::has_room_to_turn(const Pose2& pose) const {
  return Ground(grid, footprint, params.costs).clearance_m(pose.position_m()) >= footprint.long_m();
}

/// The centre plans. Meanwhile the robot gets out of where it is boxed in, turns about once if it was not sent
/// anywhere, and tries again what teammates kept it from.
void Explorer::State::await_tour(Time now, const Ground& ground, const Pose2& pose, ReplanReason reason) {
  if (reason == ReplanReason::kNone) return;
  status.activity = "waiting for a tour";
  const bool boxed_in = ground.clearance_m(pose.position_m()) < footprint.long_m();
  if (tour.targets.empty()) {
    team.retries = 0;
    const bool has_room = !boxed_in || has_room_to_turn(pose);
    if (has_room && !looked_around && status.elements > 0 && now - adopted_at > from_seconds(1.0)) {
      look_around(now, pose);
    } else if (!has_room && standstill.lasted(now) > kRecoverAfter) {
      // Nobody sends a robot anywhere that cannot get out of where it is.
      (void)get_out(now, ground, pose);
    }
    return;
  }
  if (now - team.retried_at < kRetryAfter) return;
  team.retried_at = now;
  ++team.retries;
  if (boxed_in && team.retries > 2 && get_out(now, ground, pose)) return;
  low_level.forget_unreachable();
  low_level.set_tour(tour);
}

void Explorer::State::follow(std::vector<Viewpoint> given, Time now) {
  PlannedTour planned;
  planned.viewpoints = std::move(given);
  const std::optional<Viewpoint> committed = committed_viewpoint();
  for (std::size_t i = 0; i < planned.viewpoints.size(); ++i) {
    const Pose2& at = planned.viewpoints[i].pose;
    const bool now_there = (committed && same_goal(at, committed->pose)) ||
                           (dwell && same_goal(at, dwell->viewpoint.pose)) ||
                           (last_visit && same_goal(at, last_visit->pose));
    if (!now_there) planned.tour.targets.push_back({static_cast<std::int64_t>(i), at});
  }
  if (committed) put_first(*committed, planned);
  status.clusters = static_cast<int>(planned.tour.targets.size());
  ++status.tours;
  pending = Pending{now, now, std::move(planned)};
}

bool Explorer::State::step_aside(Time now, const Pose2& pose, const Pose2& teammate, const Pose2& its_target,
                                 double clear_m) {
  const Ground without_bodies(grid, footprint, params.costs);
  const Sweep sweep(without_bodies, teammate.position_m());
  std::vector<Eigen::Vector2d> way_m = sweep.way_to(its_target.position_m());
  way_m.push_back(teammate.position_m());
  const auto aside = find_way_aside(ground_now(pose), LegPlanner(params.low_level.leg), pose, way_m, clear_m);
  if (!aside) return false;
  const std::vector<DrivePiece> leg = pieces_of(*aside);
  pieces.assign(leg.begin(), leg.end());
  recovering = true;
  standstill.begin(now);
  low_level.set_tour({});
  dwell.reset();
  status.activity = "stepping aside for a teammate";
  return true;
}

void Explorer::follow(std::vector<Viewpoint> viewpoints, Time now) {
  state_->follow(std::move(viewpoints), now);
}

void Explorer::finish() {
  state_->status.done = true;
  state_->status.left_s = 0;
}

Result<std::size_t> Explorer::fuse(const mapping::MapPatch& patch) {
  return mapping::fuse(state_->map, patch);
}

void Explorer::declare_start(const Pose2& teammate) {
  state_->grid.declare_free(teammate.position_m(), state_->params.start_clearance_m);
}

void Explorer::set_traffic(std::vector<Pose2> bodies, TrafficAdvice advice) {
  state_->team.bodies = std::move(bodies);
  state_->team.advice = advice;
}

bool Explorer::step_aside(Time now, const Pose2& pose, const Pose2& teammate, const Pose2& its_target, double clear_m) {
  return state_->step_aside(now, pose, teammate, its_target, clear_m);
}

void Explorer::give_up_tour() {
  if (const auto lost = target()) state_->team.events.push_back({TargetEvent::Kind::kUnreachable, *lost});
  restart();
}

std::optional<Pose2> Explorer::target() const {
  if (state_->dwell) return state_->dwell->viewpoint.pose;
  if (const auto target = state_->low_level.target()) return target->pose;
  if (!state_->tour.targets.empty()) return state_->tour.targets.front().pose;
  return std::nullopt;
}

bool Explorer::idle() const {
  return state_->tour.targets.empty() && !state_->dwell && !state_->pending && !state_->recovering;
}

bool Explorer::kept_by_bodies() const {
  return state_->team.retries > 0 && !state_->team.bodies.empty() && !state_->tour.targets.empty() &&
         !state_->low_level.target();
}

std::vector<TargetEvent> Explorer::take_events() {
  return std::exchange(state_->team.events, {});
}

}  // namespace arpent::planning
