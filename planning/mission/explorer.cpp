// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/explorer.h"

#include <algorithm>

#include "common/config/config.h"
#include "planning/mission/explorer_state.h"
#include "planning/mission/ground_free_space.h"
#include "planning/mission/tour_planner.h"
#include "planning/viewpoints/exploration_targets.h"

namespace arpent::planning {
namespace {

constexpr double kTrailM = 3.0;
constexpr double kBackOffM = 0.4;
constexpr int kStopsPerPlace = 2;
/// So many more images must leave it at nothing to do before that is the end.
constexpr int kLastImages = 3;
/// Standing for so long with something left to do, and no way out found, is the end.
constexpr Duration kHelplessAfter = std::chrono::seconds(30);

double margin_m(const ExplorerParams& params) {
  return planning_margin_m(params.footprint_margin_m, params.tsdf.voxel_m);
}

/// A robot that stands as near to something as its guard lets it come may set out from there, whatever the margin.
LowLevelParams low_level_of(const ExplorerParams& params) {
  LowLevelParams low_level = params.low_level;
  low_level.leg.start_slack_m += margin_m(params) - params.footprint_margin_m;
  return low_level;
}

}  // namespace

Explorer::State::State(const ExplorerParams& p, const LevelCamera& camera)
    : params(p),
      map(p.tsdf),
      targets(p.viewpoints, camera, box_between(p.region_min_m, p.region_max_m)),
      grid(p.grid),
      fresh(p.fresh),
      body_footprint(p.footprint),
      footprint(p.footprint.grown(margin_m(p))),
      low_level(low_level_of(p)),
      trail(kTrailM) {}

void Explorer::State::integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) {
  if (!map.integrate(depth, T_map_cam)) return;
  targets.update(map);
  if (!params.led) targets.note_looks(map, {&body, 1});
  grid.update(map);
  fresh.look(depth, T_map_cam, grid);
  trail.add(body);
  ++images;
  if (dwell) ++dwell->images;
  const std::vector<VoxelIndex> elements = targets.surface().voxels();
  low_level.set_incomplete(elements);
  ever.insert(elements.begin(), elements.end());
  status.elements = elements.size();
  status.elements_ever = ever.size();
}

ExplorerOrder Explorer::State::step(Time now, const Pose2& pose, const DriveState& drive) {
  if (standstill.note(now, pose)) helpless_since.reset();
  if (status.done || status.boxed_in) return {};
  if (pending && now >= pending->from) adopt(now);
  drop_completed();
  if (dwell && !targets.is_complete(dwell->viewpoint) &&
      dwell->images < std::min(dwell->viewpoint.looks, params.max_stay_images)) {
    status.activity = "looking";
    return {};
  }
  if (dwell && dwell->images >= dwell->viewpoint.looks) note_visit(dwell->viewpoint, now);
  dwell.reset();
  if (drive.blocked) return wait(pose);
  was_blocked = false;
  if (recovering && !drive.arrived && standstill.lasted(now) < from_seconds(params.stuck_s)) return {};
  if (recovering && drive.arrived && !pieces.empty()) return next_piece();
  recovering = false;
  const Ground ground = ground_now(pose);
  const LowLevelInput input{ground, grid, pose, team.advice, drive.speed_mps};
  LowLevelOutput output = low_level.step(input);
  if (output.visited) {
    begin_dwell(*output.visited);
    if (dwell) return {};
    output = low_level.step(input);
  }
  if (params.led) note_skipped(output);
  const bool stale = now - adopted_at > from_seconds(params.replan_s);
  if (!pending && (output.replan != ReplanReason::kNone || stale)) plan(now, ground, pose, output.replan);
  if (status.done || status.boxed_in || (last_image && !recovering)) return {ExplorerOrder::Kind::kStop, {}};
  if (recovering) return next_piece();
  if (output.order == DriveOrder::kGoOn && low_level.target() &&
      standstill.lasted(now) > from_seconds(params.stuck_s)) {
    return get_unstuck(now, ground, pose, drive.pushes);
  }
  return order_for(now, output, drive.arrived);
}

/// Somebody stopped it: what it was on is void, and its next leg begins where it stands. Where that happened before, it
/// stays on what cannot be driven, until it counts as stuck.
ExplorerOrder Explorer::State::wait(const Pose2& pose) {
  status.activity = "waiting: something is in the way";
  if (!std::exchange(was_blocked, true) && stopped_at.try_at(pose, kStopsPerPlace)) {
    low_level.break_off();
    pieces.clear();
    recovering = false;
  }
  return {};
}

/// The tour goes on without the targets that were completed on the way to others.
void Explorer::State::drop_completed() {
  Tour rest{{}, tour.elements};
  for (const TourTarget& target : tour.targets) {
    if (!targets.is_complete(viewpoints[static_cast<std::size_t>(target.id)])) rest.targets.push_back(target);
  }
  if (rest.targets.size() == tour.targets.size()) return;
  tour = std::move(rest);
  low_level.set_tour(tour);
  low_level.set_incomplete(targets.surface().voxels());
}

void Explorer::State::adopt(Time now) {
  // A centre that says again and again that there is nothing to drive to does not keep a robot from looking around.
  if (!params.led || !pending->tour.tour.targets.empty()) adopted_at = now;
  viewpoints = std::move(pending->tour.viewpoints);
  tour = std::move(pending->tour.tour);
  if (last_visit && last_visit->at >= pending->begun) {
    // It was thought out while the robot looked from there.
    std::erase_if(tour.targets, [&](const TourTarget& t) { return same_goal(t.pose, last_visit->pose); });
  }
  low_level.set_tour(tour);
  low_level.set_incomplete(targets.surface().voxels());
  pending.reset();
}

void Explorer::State::plan(Time now, const Ground& ground, const Pose2& pose, ReplanReason reason) {
  if (params.led) return await_tour(now, ground, pose, reason);
  if (last_image && images < *last_image) return;
  Targets found = find_targets(ground, pose);
  status.clusters = static_cast<int>(found.clusters.size());
  status.activity = std::string("planning: ") + to_text(reason);
  ++status.tours;
  const bool tight = ground.clearance_m(pose.position_m()) < footprint.long_m();
  const double largest_m2 = static_cast<double>(found.largest()) * params.tsdf.voxel_m * params.tsdf.voxel_m;
  if (!looked_around && !tight && largest_m2 < params.viewpoints.min_viewpoint_m2) return look_around(now, pose);
  if (found.clusters.empty() || reason == ReplanReason::kNothingReachable) {
    if (tight && get_out(now, ground, pose)) return;
    if (recover_by_the_way_it_came(now, ground, pose)) return;
  }
  if (is_helpless(now, reason)) {
    status.boxed_in = true;
    status.activity = "boxed in: there is no way out of where it stands";
    return;
  }
  if (found.clusters.empty()) return end();
  last_image.reset();
  const std::optional<Viewpoint> committed = committed_viewpoint();
  PlannedTour planned = plan_tour(ground, found.clusters, committed ? committed->pose : pose, params.tour,
                                  {params.nominal_speed_mps, params.nominal_turn_rate_radps, params.visit_s});
  if (committed) put_first(*committed, planned);
  status.left_s = planned.completion_s;
  pending = Pending{now, now + from_seconds(params.plan_latency_s), std::move(planned)};
}

/// Found twice, with a few images in between, to have nothing left to do.
void Explorer::State::end() {
  status.done = last_image.has_value();
  status.left_s = 0;
  status.activity = "nothing is left that could be completed";
  last_image = images + kLastImages;
  low_level.set_tour(tour = {});
  pieces.clear();
}

/// Places where the robot can turn come first; then any; then also those to which no leg was found once.
Targets Explorer::State::find_targets(const Ground& ground, const Pose2& pose) {
  Targets found;
  for (int attempt = 0; attempt < 3 && found.clusters.empty(); ++attempt) {
    if (attempt == 2 && (low_level.unreachable().all().empty() || --chances < 0)) break;
    if (attempt == 2) low_level.forget_unreachable();
    found = targets.plan(map, GroundFreeSpace(ground, grid, low_level.unreachable(), pose, attempt == 0), pose);
  }
  return found;
}

/// False if that was tried here already.
bool Explorer::State::assume_free(const Pose2& pose) {
  for (const Eigen::Vector2d& before : assumed_free_m) {
    if ((before - pose.position_m()).norm() < 0.5 * footprint.long_m()) return false;
  }
  assumed_free_m.push_back(pose.position_m());
  grid.declare_free(pose.position_m(), footprint.long_m() + params.grid.cell_m);
  ++status.assumed_free;
  return true;
}

/// What the robot is on its way to, if it is still worth the way: a better idea every other second would have it pace
/// to and fro.
std::optional<Viewpoint> Explorer::State::committed_viewpoint() const {
  const auto target = low_level.target();
  if (!target) return std::nullopt;
  const Viewpoint& viewpoint = viewpoints[static_cast<std::size_t>(target->id)];
  if (targets.is_complete(viewpoint)) return std::nullopt;
  return viewpoint;
}

/// Where nothing much can be seen to be completed, turning once about shows where to go: as long as the camera sees
/// only a narrow lane, viewpoints are many and tiny.
void Explorer::State::look_around(Time now, const Pose2& pose) {
  looked_around = true;
  status.activity = "looking around";
  const std::vector<DrivePiece> turns = turn_about(pose);
  pieces.assign(turns.begin(), turns.end());
  recovering = true;
  standstill.begin(now);
}

void Explorer::State::begin_dwell(std::int64_t target) {
  pieces.clear();
  std::erase_if(tour.targets, [&](const TourTarget& t) { return t.id == target; });
  const Viewpoint& viewpoint = viewpoints[static_cast<std::size_t>(target)];
  if (!targets.is_complete(viewpoint)) dwell = Dwell{viewpoint, 0};
}

ExplorerOrder Explorer::State::order_for(Time now, const LowLevelOutput& output, bool arrived) {
  if (output.order == DriveOrder::kFollow) {
    team.retries = 0;
    const std::vector<DrivePiece> leg = pieces_of(*output.leg);
    pieces.assign(leg.begin(), leg.end());
    standstill.begin(now);
    return next_piece();
  }
  if (output.order == DriveOrder::kStop) {
    pieces.clear();
    return {ExplorerOrder::Kind::kStop, {}};
  }
  if (arrived && !pieces.empty()) return next_piece();
  if (low_level.target()) status.activity = "driving to a viewpoint";
  return {};
}

ExplorerOrder Explorer::State::next_piece() {
  if (pieces.empty()) return {};
  ExplorerOrder order{ExplorerOrder::Kind::kDrive, std::move(pieces.front())};
  pieces.pop_front();
  return order;
}

/// The robot stands though it has a leg to drive: it was stopped, or pushes against what nothing shows. It backs off,
/// and goes on with a tour made anew.
ExplorerOrder Explorer::State::get_unstuck(Time now, const Ground& ground, const Pose2& pose, bool pushes) {
  if (const auto target = low_level.target()) team.events.push_back({TargetEvent::Kind::kUnreachable, target->pose});
  low_level.give_up_target({ground, grid, pose});
  if (pushes) fresh.touch(body_footprint, pose, grid);
  tour = {};
  pieces.clear();
  status.activity = "giving up a leg that could not be driven";
  if (recover(now, pose, back_off(ground, pose, trail, kBackOffM, params.recovery))) return next_piece();
  return {ExplorerOrder::Kind::kStop, {}};
}

/// Puts the recovery, if there is one and it has not failed here before, in the place of the leg.
bool Explorer::State::recover(Time now, const Pose2& pose, const std::optional<Recovery>& recovery, int most) {
  if (!recovery || !recovered_at.try_at(pose, most)) return false;
  ++status.recoveries;
  status.activity = "getting out of where it is boxed in";
  pieces = {piece_of(*recovery, pose)};
  recovering = true;
  standstill.begin(now);
  return true;
}

/// Of where it is boxed in. By ground that it has not seen: then it assumes once more what it assumed at the start.
bool Explorer::State::get_out(Time now, const Ground& ground, const Pose2& pose) {
  return recover(now, pose, plan_recovery(ground, pose, trail, params.recovery)) || assume_free(pose);
}

bool Explorer::State::is_helpless(Time now, ReplanReason reason) {
  if (reason != ReplanReason::kNothingReachable) return false;
  helpless_since = helpless_since.value_or(now);
  return now - *helpless_since > kHelplessAfter;
}

/// The last resort, once per place: back to where it was a moment ago, though the map has something there now. The
/// guard that stops it for what it sees is still awake.
bool Explorer::State::recover_by_the_way_it_came(Time now, const Ground& ground, const Pose2& pose) {
  if (standstill.lasted(now) < from_seconds(params.stuck_s)) return false;
  RecoveryParams bold = params.recovery;
  bold.max_deeper_m += params.footprint_margin_m + params.grid.cell_m;
  return recover(now, pose, back_off(ground, pose, trail, kBackOffM, bold), kRecoveriesPerPlace + 1);
}

Explorer::Explorer(const ExplorerParams& params, const LevelCamera& camera) {
  config::check(params, "explorer");
  state_ = std::make_unique<State>(params, camera);
}
Explorer::~Explorer() = default;

void Explorer::begin(const Pose2& start) {
  state_->grid.declare_free(start.position_m(), state_->params.start_clearance_m);
  if (state_->params.led) state_->grid.declare_body(state_->body_footprint, start);
}

void Explorer::integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) {
  state_->integrate(depth, T_map_cam, body);
}

ExplorerOrder Explorer::step(Time now, const Pose2& pose, const DriveState& drive) {
  return state_->step(now, pose, drive);
}

void Explorer::restart() {
  state_->tour = {};
  state_->low_level.set_tour({});
  state_->pieces.clear();
  state_->dwell.reset();
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
