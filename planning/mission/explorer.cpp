// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/explorer.h"

#include "common/config/config.h"
#include "planning/mission/explorer_state.h"

namespace arpent::planning {

Explorer::Explorer(const ExplorerParams& params, const LevelCamera& camera) {
  config::check(params, "explorer");
  state_ = std::make_unique<State>(params, camera);
}
Explorer::~Explorer() = default;

void Explorer::begin(const Pose2& start) {
  state_->grid.declare_free(start.position_m(), state_->params.start_clearance_m);
  if (state_->params.led) state_->grid.declare_body(Footprint(state_->params.footprint), start);
}

void Explorer::integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) {
  state_->integrate(depth, T_map_cam, body);
}

ExplorerOrder Explorer::step(Time now, const Pose2& pose, bool arrived, bool blocked) {
  return state_->step(now, pose, arrived, blocked);
}

void Explorer::restart() {
  state_->tour = {};
  state_->low_level.set_tour({});
  state_->pieces.clear();
  state_->dwell.reset();
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

const ExplorerStatus& Explorer::status() const {
  return state_->status;
}
const mapping::TsdfMap& Explorer::map() const {
  return state_->map;
}
ExplorationTargets::Certification Explorer::certify(const Pose2& pose) const {
  const Ground ground(state_->grid, state_->footprint, state_->params.costs);
  const UnreachableGoals none;
  return state_->targets.certify(state_->map, GroundFreeSpace(ground, state_->grid, none, pose, false), pose);
}

}  // namespace arpent::planning
