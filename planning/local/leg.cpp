// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/leg.h"

#include <algorithm>
#include <cmath>

namespace arpent::planning {
namespace {

constexpr double kPointSpacingM = 0.05;
constexpr double kPlaceSpacingRad = 0.1;
constexpr double kLookAheadM = 1.0;
/// So many radians weigh as much as a metre.
constexpr double kRadPerM = 3.0;
constexpr double kLeastDriveM = 1e-4;
constexpr double kLeastTurnRad = 1e-3;

/// The part of a motion after `share`.
Motion rest_of(const Motion& motion, double share) {
  Motion rest = motion;
  rest.start = pose_at(motion, share);
  rest.length_m *= 1 - share;
  rest.turn_rad *= 1 - share;
  return rest;
}

Motion begin_of(const Motion& motion, double share) {
  Motion begin = motion;
  begin.length_m *= share;
  begin.turn_rad *= share;
  return begin;
}

/// Share at which the motion first touches, with slack on the first `slack_along_m` of it.
std::optional<double> contact_of(const Ground& ground, const Motion& motion, double depth_m, double slack_along_m) {
  if (depth_m <= 0 || slack_along_m <= 0) return ground.first_contact(motion);
  if (motion.is_turn() || slack_along_m >= motion.length_m) return ground.first_contact(motion, depth_m);
  const double share = slack_along_m / motion.length_m;
  if (const auto contact = ground.first_contact(begin_of(motion, share), depth_m)) return *contact * share;
  const auto contact = ground.first_contact(rest_of(motion, share));
  return contact ? std::optional(share + *contact * (1 - share)) : std::nullopt;
}

void append_points(std::vector<Eigen::Vector2d>& points, const Motion& motion) {
  const int steps = std::max(1, static_cast<int>(std::ceil(motion.length_m / kPointSpacingM)));
  if (points.empty()) points.push_back(motion.start.position_m());
  for (int i = 1; i <= steps; ++i) points.push_back(pose_at(motion, static_cast<double>(i) / steps).position_m());
}

}  // namespace

std::optional<LegPlace> first_contact(const Ground& ground, const Motions& motions, const StartSlack& slack,
                                      const LegPlace& from) {
  double driven_m = from.driven_m;
  for (std::size_t i = from.motion; i < motions.size(); ++i) {
    const double begin = i == from.motion ? from.share : 0;
    const Motion rest = begin > 0 ? rest_of(motions[i], std::min(begin, 1.0)) : motions[i];
    // What is left of a drive when nothing is left of it is not a turn.
    if (!motions[i].is_turn() && rest.length_m <= 0) continue;
    if (const auto contact = contact_of(ground, rest, slack.depth_m, slack.along_m - driven_m)) {
      return LegPlace{i, begin + *contact * (1 - begin), driven_m + *contact * rest.length_m};
    }
    driven_m += rest.length_m;
  }
  return std::nullopt;
}

Motions tidy(const Motions& motions) {
  Motions joined;
  for (const Motion& motion : motions) {
    if (motion.is_turn() ? std::abs(motion.turn_rad) < kLeastTurnRad : motion.length_m < kLeastDriveM) continue;
    if (!joined.empty() && joined.back().is_turn() && motion.is_turn()) {
      joined.back().turn_rad = wrap_angle(joined.back().turn_rad + motion.turn_rad);
    } else if (!joined.empty() && !joined.back().is_turn() && !motion.is_turn() &&
               std::abs(joined.back().curvature_1pm - motion.curvature_1pm) < 1e-9) {
      joined.back().length_m += motion.length_m;
    } else {
      joined.push_back(motion);
    }
  }
  return joined;
}

LegProgress::LegProgress(const Leg& leg) {
  LegPlace place;
  places_.push_back({leg.start, place});
  for (std::size_t i = 0; i < leg.motions.size(); ++i) {
    const Motion& motion = leg.motions[i];
    const double size =
        motion.is_turn() ? std::abs(motion.turn_rad) / kPlaceSpacingRad : motion.length_m / kPointSpacingM;
    const int steps = std::max(1, static_cast<int>(std::ceil(size)));
    for (int k = 1; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      places_.push_back({pose_at(motion, share), {i, share, place.driven_m + share * motion.length_m}});
    }
    place.driven_m += motion.length_m;
  }
}

void LegProgress::advance(const Pose2& pose) {
  const auto off = [&](const Place& p) {
    return std::hypot((p.pose.position_m() - pose.position_m()).norm(),
                      wrap_angle(p.pose.yaw_rad - pose.yaw_rad) / kRadPerM);
  };
  double least = off(places_[at_]);
  const double far_m = places_[at_].place.driven_m + kLookAheadM;
  for (std::size_t i = at_ + 1; i < places_.size() && places_[i].place.driven_m <= far_m; ++i) {
    if (off(places_[i]) > least) continue;
    least = off(places_[i]);
    at_ = i;
  }
  off_m_ = (places_[at_].pose.position_m() - pose.position_m()).norm();
}

std::vector<DrivePiece> pieces_of(const Leg& leg) {
  std::vector<DrivePiece> pieces;
  std::vector<Eigen::Vector2d> points;
  double length_m = 0;
  double heading = leg.start.yaw_rad;
  const auto finish = [&](double end_heading_rad) {
    // A few millimetres are no drive: the goal's tolerance covers them.
    if (length_m >= kCreepM) pieces.push_back({std::move(points), end_heading_rad});
    points.clear();
    length_m = 0;
  };
  for (const Motion& motion : leg.motions) {
    if (motion.is_turn()) {
      heading = end_of(motion).yaw_rad;
      finish(heading);
    } else {
      append_points(points, motion);
      length_m += motion.length_m;
      heading = end_of(motion).yaw_rad;
    }
  }
  finish(heading);
  if (!pieces.empty()) {
    pieces.back().end_heading_rad = leg.goal.yaw_rad;
  } else if (!leg.motions.empty()) {
    const Eigen::Vector2d p = leg.start.position_m();
    const Eigen::Vector2d ahead(std::cos(leg.start.yaw_rad), std::sin(leg.start.yaw_rad));
    pieces.push_back({{p, p + kCreepM * ahead}, leg.goal.yaw_rad});
  }
  return pieces;
}

}  // namespace arpent::planning
