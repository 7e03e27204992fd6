// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/team/traffic.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/config.h"
#include "planning/local/obstacles.h"

namespace arpent::planning {
namespace {

constexpr double kStepM = 0.1;
constexpr double kStepS = 0.25;
constexpr double kTurnStepRad = 0.25;
constexpr double kMovingMps = 0.03;
constexpr double kMovingRadps = 0.1;
/// What a robot that stands may do before it is noticed.
constexpr double kStartM = 0.2;

/// Of a robot that fell silent: the age of its last state and the time of its dead man's switch; and how it brakes.
constexpr double kLostDelayS = 0.5;
constexpr double kLostMps2 = 0.5;

bool moves(const Vehicle& v) {
  return !v.lost && (std::abs(v.twist.speed_mps) > kMovingMps || std::abs(v.twist.turn_rate_radps) > kMovingRadps);
}

/// Poses along the way as far as `length_m`, `kStepM` apart, the turn on the spot before it first. `driven_m`: their
/// places on the way.
struct Way {
  std::vector<Pose2> poses;
  std::vector<double> driven_m;

  void add(const Pose2& pose, double at_m) {
    poses.push_back(pose);
    driven_m.push_back(at_m);
  }
};

/// The headings of a turn on the spot, but for the first.
void add_turn_to(Way& way, const Pose2& from, double heading_rad, double at_m) {
  const double turn = wrap_angle(heading_rad - from.yaw_rad);
  const int turns = static_cast<int>(std::ceil(std::abs(turn) / kTurnStepRad));
  for (int i = 1; i <= turns; ++i) way.add({from.x_m, from.y_m, wrap_angle(from.yaw_rad + i * turn / turns)}, at_m);
}

Way way_of(const Vehicle& v, double length_m) {
  Way way;
  way.add(v.pose, 0);
  Pose2 at = v.pose;
  double driven = 0;
  for (const Eigen::Vector2d& next : v.path_m) {
    const Eigen::Vector2d step = next - at.position_m();
    if (step.norm() < kStepM) continue;
    const double tangent = std::atan2(step.y(), step.x());
    const double heading = v.backwards ? wrap_angle(tangent + std::numbers::pi) : tangent;
    if (driven == 0) add_turn_to(way, at, heading, 0);
    const int steps = std::max(1, static_cast<int>(std::ceil(step.norm() / kStepM)));
    for (int i = 1; i <= steps; ++i) {
      const double share = static_cast<double>(i) / steps;
      if (driven + share * step.norm() > length_m) return way;
      way.add({at.x_m + share * step.x(), at.y_m + share * step.y(), heading}, driven + share * step.norm());
    }
    driven += step.norm();
    at = {next.x(), next.y(), heading};
  }
  if (v.end_heading_rad) add_turn_to(way, at, *v.end_heading_rad, driven);
  return way;
}

/// What it turns through before it stands.
void add_turn(Way& way, const Vehicle& v, double delay_s) {
  if (std::abs(v.twist.turn_rate_radps) <= kMovingRadps) return;
  for (const double share : {0.5, 1.0}) {
    way.add({v.pose.x_m, v.pose.y_m, wrap_angle(v.pose.yaw_rad + share * delay_s * v.twist.turn_rate_radps)}, 0);
  }
}

/// Where it goes on straight if its way is not known.
void add_drift(Way& way, const Vehicle& v, double length_m) {
  for (double d = kStepM; d <= length_m; d += kStepM) {
    const double signed_d = std::copysign(d, v.twist.speed_mps);
    way.add({v.pose.x_m + signed_d * std::cos(v.pose.yaw_rad), v.pose.y_m + signed_d * std::sin(v.pose.yaw_rad),
             v.pose.yaw_rad},
            d);
  }
}

}  // namespace

std::vector<Pose2> resting_places(const Pose2& last, const Twist2& twist) {
  const double time_s = kLostDelayS + std::abs(twist.speed_mps) / (2 * kLostMps2);
  const double way_m = twist.speed_mps * time_s, turn_rad = twist.turn_rate_radps * time_s;
  const int steps = static_cast<int>(std::ceil(std::max(std::abs(way_m) / kStepM, std::abs(turn_rad) / kTurnStepRad)));
  std::vector<Pose2> places = {last};
  for (int i = 0; i < steps; ++i) {
    const Pose2& from = places.back();
    const double middle = from.yaw_rad + 0.5 * turn_rad / steps;
    places.push_back({from.x_m + way_m / steps * std::cos(middle), from.y_m + way_m / steps * std::sin(middle),
                      wrap_angle(from.yaw_rad + turn_rad / steps)});
  }
  return places;
}

Traffic::Traffic(const TrafficParams& params, const Footprint& footprint) : params_(params), footprint_(footprint) {
  config::check(params, "traffic");
}

double Traffic::stopping_m(double speed_mps) const {
  const double v = std::abs(speed_mps);
  return v * v / (2 * params_.deceleration_mps2) + params_.delay_s * v;
}

/// Whether what both sweep before they stand comes too near. A robot that already is nearer than the gap may go where
/// it gets no nearer.
bool Traffic::must_brake(const Vehicle& own, const Vehicle& other) const {
  const double stop_m = stopping_m(own.twist.speed_mps);
  if (!moves(own) && own.path_m.empty()) return false;
  Way mine = way_of(own, std::max(kStartM, stop_m));
  if (moves(own)) add_drift(mine, own, stop_m);
  add_turn(mine, own, params_.delay_s);
  Way theirs;
  if (other.lost) {
    for (const Pose2& pose : resting_places(other.pose, other.twist)) theirs.add(pose, 0);
  } else {
    theirs.add(other.pose, 0);
  }
  if (moves(other)) {
    const double length_m = stopping_m(other.twist.speed_mps);
    theirs = way_of(other, length_m);
    add_drift(theirs, other, length_m);
    add_turn(theirs, other, params_.delay_s);
  }
  const double wanted_m = std::min(params_.gap_m, gap_m(footprint_, own.pose, other.pose) - 0.005);
  return std::any_of(mine.poses.begin(), mine.poses.end(), [&](const Pose2& a) {
    return std::any_of(theirs.poses.begin(), theirs.poses.end(),
                       [&](const Pose2& b) { return gap_m(footprint_, a, b) < wanted_m; });
  });
}

/// Whether a teammate that goes first would meet this robot on its way within the horizon, so near that it is time to
/// stop; and would not if it stopped now.
bool Traffic::must_yield(const Vehicle& own, const Vehicle& other) const {
  if (other.lost || other.path_m.empty() || !(other.name < own.name) || own.path_m.empty()) return false;
  const double reach_m = params_.nominal_speed_mps * params_.horizon_s;
  if ((own.pose.position_m() - other.pose.position_m()).norm() > 2 * (reach_m + footprint_.long_m())) return false;
  const Way mine = way_of(own, reach_m), theirs = way_of(other, reach_m);
  const double wide_m = params_.gap_m + 0.05, stop_m = stopping_m(own.twist.speed_mps) + footprint_.long_m();
  const bool stays_clear = std::none_of(theirs.poses.begin(), theirs.poses.end(),
                                        [&](const Pose2& b) { return gap_m(footprint_, own.pose, b) < wide_m; });
  if (!stays_clear) return false;
  for (std::size_t i = 0; i < mine.poses.size(); ++i) {
    if (mine.driven_m[i] > stop_m + 0.5) break;
    const double t = mine.driven_m[i] / params_.nominal_speed_mps;
    for (std::size_t j = 0; j < theirs.poses.size(); ++j) {
      const double u = theirs.driven_m[j] / params_.nominal_speed_mps;
      // Who goes first is let by until it is past: later than this robot would be there does not help.
      if (u > t + params_.slack_s + kStepS) continue;
      if (gap_m(footprint_, mine.poses[i], theirs.poses[j]) < wide_m) return true;
    }
  }
  return false;
}

TrafficDecision Traffic::step(Time now, const Vehicle& own, const std::vector<Vehicle>& others) {
  for (const Vehicle& other : others) {
    const bool brakes = must_brake(own, other);
    // Once stopped, it does not wait for those that stand: its next leg leads round them.
    const bool in_the_way = brakes && (!stopped_at_ || moves(other));
    if (!in_the_way && !must_yield(own, other)) continue;
    stopped_at_ = now;
    because_of_ = other.name;
  }
  if (stopped_at_ && now - *stopped_at_ > from_seconds(params_.release_s)) stopped_at_.reset();
  if (!stopped_at_) return {};
  return {TrafficAdvice::kYield, because_of_};
}

bool Traffic::may_start(Time now, const Vehicle& own, const std::vector<Vehicle>& others) {
  const auto met = std::find_if(others.begin(), others.end(),
                                [&](const Vehicle& other) { return must_brake(own, other) || must_yield(own, other); });
  if (met == others.end()) return true;
  stopped_at_ = now;
  because_of_ = met->name;
  return false;
}

}  // namespace arpent::planning
