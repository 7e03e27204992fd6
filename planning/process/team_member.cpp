// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/process/team_member.h"

#include <algorithm>
#include <cmath>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "mapping/wire.h"
#include "planning/team/wire.h"

namespace arpent {
namespace {

using planning::MissionState;

/// Of its way a robot sends this much, in points so far apart.
constexpr double kSentM = 3.0;
constexpr double kSentSpacingM = 0.2;
/// A way that leads nowhere farther than this is driven.
constexpr double kDrivenM = 0.15;
/// After a manoeuvre for a teammate, the next not before:
constexpr Duration kAsideAgain = std::chrono::seconds(4);
/// Ways in a row that may not be begun, after which the robot makes room by itself.
constexpr int kRefusedTooOften = 8;
/// So many, and the teammate that is in the way is asked for room.
constexpr int kRefusedOften = 3;
/// A robot that is jammed again this near to where it was has not got out by stepping aside.
constexpr double kSamePlaceM = 0.2;

/// What is left of the way from the point nearest to the body.
std::vector<Eigen::Vector2d> rest_of(const std::vector<Eigen::Vector2d>& way_m, const Eigen::Vector2d& body_m) {
  if (way_m.empty()) return {};
  const auto nearest = std::min_element(way_m.begin(), way_m.end(), [&](const auto& a, const auto& b) {
    return (a - body_m).squaredNorm() < (b - body_m).squaredNorm();
  });
  return {nearest, way_m.end()};
}

std::vector<Eigen::Vector2d> shorten(const std::vector<Eigen::Vector2d>& way_m) {
  std::vector<Eigen::Vector2d> sent;
  double length_m = 0, since_m = kSentSpacingM;
  for (std::size_t i = 0; i < way_m.size() && length_m < kSentM; ++i) {
    const double step_m = i == 0 ? 0 : (way_m[i] - way_m[i - 1]).norm();
    length_m += step_m;
    since_m += step_m;
    if (since_m < kSentSpacingM && i + 1 < way_m.size()) continue;
    sent.push_back(way_m[i]);
    since_m = 0;
  }
  return sent;
}

}  // namespace

TeamMember::TeamMember(const TeamMemberParams& params, const planning::FootprintParams& footprint,
                       planning::Explorer& explorer, Bus& bus, Clock& clock)
    : params_(params),
      traffic_(params.traffic, planning::Footprint(footprint)),
      explorer_(explorer),
      bus_(bus),
      clock_(clock) {
  listen();
}

void TeamMember::listen() {
  const auto refuse = [this](const char* channel, const std::string& fault) {
    bus_.health().count(channel, "invalid");
    bus_.health().warn(std::string(channel) + ": message dropped: " + fault);
  };
  subscribe<robot_state_t>(bus_, channels::kTeamState, {.queue_capacity = 64}, [=, this](const robot_state_t& m) {
    const auto state = planning::from_wire(m);
    state ? take(*state) : refuse(channels::kTeamState, state.fault());
  });
  subscribe<tour_t>(bus_, channels::kTeamTour, {.queue_capacity = 16}, [=, this](const tour_t& m) {
    const auto tour = planning::from_wire(m);
    tour ? take(*tour) : refuse(channels::kTeamTour, tour.fault());
  });
  subscribe<map_patch_t>(bus_, channels::kTeamPatch, {.queue_capacity = 256}, [=, this](const map_patch_t& m) {
    const auto patch = mapping::from_wire(m);
    if (!patch) return refuse(channels::kTeamPatch, patch.fault());
    const auto fused = explorer_.fuse(*patch);
    if (!fused) refuse(channels::kTeamPatch, fused.fault());
  });
}

void TeamMember::take(const planning::RobotState& state) {
  const auto [held, is_new] = teammates_.try_emplace(state.robot, Teammate{state, clock_.now()});
  if (is_new) explorer_.declare_start(state.body);
  if (!is_new && state.stamp > held->second.state.stamp) held->second = {state, clock_.now()};
  poses_.note({state.robot, state.stamp, state.body, state.twist});
}

void TeamMember::take(const planning::TeamTour& tour) {
  if (tour.robot != params_.robot || tour.number <= tour_) return;
  if (!newest_stamp_ || *newest_stamp_ - tour.state_stamp > from_seconds(tour.valid_s)) {
    bus_.health().count(channels::kTeamTour, "expired");
    return;
  }
  tour_ = tour.number;
  if (tour.done) return explorer_.finish();
  explorer_.follow(tour.viewpoints, clock_.now());
}

void TeamMember::mask(Time stamp, stereo::DepthMap& depth, const Pose& T_map_cam) const {
  (void)mapping::mask_teammates(depth, T_map_cam, poses_.at(stamp), params_.mask);
}

std::vector<planning::Vehicle> TeamMember::vehicles() const {
  std::vector<planning::Vehicle> vehicles;
  for (const auto& [name, mate] : teammates_) {
    const bool lost = clock_.now() - mate.heard_at > from_seconds(params_.silent_s);
    planning::Vehicle vehicle{name, mate.state.body, mate.state.twist, {}};
    vehicle.lost = lost;
    if (!lost) vehicle.path_m = mate.state.path_m;
    vehicles.push_back(std::move(vehicle));
  }
  return vehicles;
}

planning::Vehicle TeamMember::own(const Pose2& body) const {
  planning::Vehicle vehicle{params_.robot, body, twist_, rest_of(way_.points_m, body.position_m())};
  vehicle.backwards = way_.backwards;
  vehicle.end_heading_rad = way_.goal_heading_rad;
  return vehicle;
}

std::vector<Pose2> TeamMember::bodies_in_the_way(const Pose2& body) const {
  std::vector<Pose2> bodies;
  for (const planning::Vehicle& mate : vehicles()) {
    if (mate.lost) {
      const std::vector<Pose2> places = planning::resting_places(mate.pose, mate.twist);
      bodies.insert(bodies.end(), places.begin(), places.end());
      continue;
    }
    const bool stands = std::abs(mate.twist.speed_mps) < planning::kStandsMps && mate.path_m.empty();
    const bool near = (mate.pose.position_m() - body.position_m()).norm() < params_.traffic.near_m;
    if (stands || near) bodies.push_back(mate.pose);
  }
  return bodies;
}

bool TeamMember::step(MissionState mission, Time stamp, const Pose2& body, const Twist2& twist,
                      double position_sigma_m) {
  twist_ = twist;
  newest_stamp_ = stamp;
  const planning::TrafficDecision decision = traffic_.step(clock_.now(), own(body), vehicles());
  const bool yields = decision.advice == planning::TrafficAdvice::kYield;
  const bool stop = yields && !yields_;
  // What it was stopped on is void: the next leg is looked for anew, with the next depth image.
  if (yields_ && !yields) way_ = {};
  if (stop) bus_.health().count("TRAFFIC", "stops");
  yields_ = yields;
  if (yields) yields_to_ = decision.because_of;
  explorer_.set_traffic(bodies_in_the_way(body), decision.advice);
  if (mission == MissionState::kRunning && !yields) make_room(body);
  report(mission, stamp, body, position_sigma_m);
  return stop;
}

void TeamMember::note_stop() {
  if (!yields_) way_ = {};
}

bool TeamMember::may_drive(const Pose2& body, const planning::PathRequest& way) {
  way_ = way;
  if (yields_) return false;
  if (traffic_.may_start(clock_.now(), own(body), vehicles())) {
    refused_ = 0;
    return true;
  }
  ++refused_;
  bus_.health().count("TRAFFIC", "refused");
  explorer_.set_traffic(bodies_in_the_way(body), planning::TrafficAdvice::kYield);
  return false;
}

/// Steps aside for a teammate that stands because of this robot: one that goes first, or any if this one has nothing to
/// do. A robot whose ways are refused again and again makes room as well.
void TeamMember::make_room(const Pose2& body) {
  if (aside_at_ && clock_.now() - *aside_at_ < kAsideAgain) return;
  // The way aside begins where it stands.
  if (std::abs(twist_.speed_mps) > planning::kStandsMps) return;
  for (const auto& [name, mate] : teammates_) {
    const bool asks = mate.state.blocked_by == params_.robot && (name < params_.robot || explorer_.idle());
    const bool jammed = refused_ >= kRefusedTooOften && name == nearest_to(body);
    if (!asks && !jammed) continue;
    aside_at_ = clock_.now();
    refused_ = 0;
    const bool again = jammed && jammed_m_ && (*jammed_m_ - body.position_m()).norm() < kSamePlaceM;
    if (jammed) jammed_m_ = body.position_m();
    const Pose2 to = mate.state.target.value_or(body);
    const bool aside =
        !again && explorer_.step_aside(clock_.now(), body, mate.state.body, to, params_.traffic.aside_clear_m);
    if (!aside && jammed) explorer_.give_up_tour();
    bus_.health().count("TRAFFIC", aside ? "asides" : "no_way_aside");
    return;
  }
}

std::string TeamMember::nearest_to(const Pose2& body) const {
  const auto off_m = [&](const auto& entry) {
    return (entry.second.state.body.position_m() - body.position_m()).norm();
  };
  const auto nearest = std::min_element(teammates_.begin(), teammates_.end(),
                                        [&](const auto& a, const auto& b) { return off_m(a) < off_m(b); });
  return nearest == teammates_.end() ? "" : nearest->first;
}

/// What teammates are told of the way: nothing once it is driven, or they would wait for a robot that stands.
std::vector<Eigen::Vector2d> TeamMember::way_ahead(const Eigen::Vector2d& body_m) const {
  std::vector<Eigen::Vector2d> way_m = shorten(rest_of(way_.points_m, body_m));
  const bool driven =
      std::all_of(way_m.begin(), way_m.end(), [&](const Eigen::Vector2d& p) { return (p - body_m).norm() < kDrivenM; });
  if (driven) way_m.clear();
  return way_m;
}

void TeamMember::report(MissionState mission, Time stamp, const Pose2& body, double position_sigma_m) {
  planning::RobotState state;
  state.stamp = stamp;
  state.robot = params_.robot;
  state.state = mission;
  state.body = body;
  state.twist = twist_;
  state.position_sigma_m = position_sigma_m;
  state.tour = tour_;
  state.idle = explorer_.idle();
  state.target = explorer_.target();
  if (explorer_.kept_by_bodies()) {
    state.blocked_by = nearest_to(body);
  } else if (refused_ >= kRefusedOften) {
    state.blocked_by = yields_to_;
  }
  if (mission == MissionState::kRunning && !yields_) state.path_m = way_ahead(body.position_m());
  publish(bus_, channels::kRobotState, planning::to_wire(state));
  for (const planning::TargetEvent& event : explorer_.take_events()) {
    publish(bus_, channels::kTourReport, planning::to_wire(planning::TourReport{stamp, params_.robot, event}));
  }
}

}  // namespace arpent
