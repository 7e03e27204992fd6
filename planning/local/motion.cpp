// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/motion.h"

#include <algorithm>
#include <cmath>

namespace arpent::planning {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
/// Shorter pieces and smaller turns are nothing.
constexpr double kNothing = 1e-7;

/// In [0, 2 pi); what rounding leaves of a full turn is none.
double positive(double angle) {
  const double a = angle - kTwoPi * std::floor(angle / kTwoPi);
  return a > kTwoPi - kNothing ? 0 : a;
}

void append_drive(Motions& motions, const Pose2& start, double length_m, double curvature_1pm) {
  const Pose2 from = motions.empty() ? start : end_of(motions.back());
  if (length_m > kNothing) motions.push_back(drive(from, length_m, curvature_1pm));
}

void append_turn(Motions& motions, const Pose2& start, double heading_rad) {
  const Motion turn = turn_to(motions.empty() ? start : end_of(motions.back()), heading_rad);
  if (std::abs(turn.turn_rad) > kNothing) motions.push_back(turn);
}

Eigen::Vector2d centre_of_circle(const Pose2& pose, double signed_radius_m) {
  return pose.position_m() + signed_radius_m * Eigen::Vector2d(-std::sin(pose.yaw_rad), std::cos(pose.yaw_rad));
}

/// Arc of side s1 (+1 left, -1 right), straight, arc of side s2; nothing if the circles are too close.
std::optional<Motions> arc_straight_arc(const Pose2& start, const Pose2& goal, double radius_m, int s1, int s2) {
  const Eigen::Vector2d d = centre_of_circle(goal, s2 * radius_m) - centre_of_circle(start, s1 * radius_m);
  const double distance = d.norm();
  double straight = distance;
  double heading = std::atan2(d.y(), d.x());
  if (s1 != s2) {
    const double across = 2 * radius_m;
    if (distance < across) return std::nullopt;
    straight = std::sqrt(distance * distance - across * across);
    heading += s1 * std::atan2(across, straight);
  } else if (distance < kNothing) {
    heading = start.yaw_rad;
  }
  Motions motions;
  append_drive(motions, start, radius_m * positive(s1 * (heading - start.yaw_rad)), s1 / radius_m);
  append_drive(motions, start, straight, 0);
  append_drive(motions, start, radius_m * positive(s2 * (goal.yaw_rad - heading)), s2 / radius_m);
  return motions;
}

/// Arc of side s, then straight to the goal's place; nothing if that lies within the circle.
std::optional<Motions> arc_straight(const Pose2& start, const Pose2& goal, double radius_m, int s) {
  const Eigen::Vector2d d = goal.position_m() - centre_of_circle(start, s * radius_m);
  const double distance = d.norm();
  if (distance < radius_m) return std::nullopt;
  const double straight = std::sqrt(distance * distance - radius_m * radius_m);
  const double heading = std::atan2(d.y(), d.x()) + s * std::atan2(radius_m, straight);
  Motions motions;
  append_drive(motions, start, radius_m * positive(s * (heading - start.yaw_rad)), s / radius_m);
  append_drive(motions, start, straight, 0);
  append_turn(motions, start, goal.yaw_rad);
  return motions;
}

void sort_by_length(std::vector<Motions>& ways) {
  std::stable_sort(ways.begin(), ways.end(), [](const auto& a, const auto& b) { return length_of(a) < length_of(b); });
}

}  // namespace

Motion drive(const Pose2& start, double length_m, double curvature_1pm) {
  return {start, length_m, curvature_1pm, 0};
}

Motion turn_to(const Pose2& start, double heading_rad) {
  return {start, 0, 0, wrap_angle(heading_rad - start.yaw_rad)};
}

Pose2 pose_at(const Motion& motion, double share) {
  const Pose2& from = motion.start;
  if (motion.is_turn()) return {from.x_m, from.y_m, wrap_angle(from.yaw_rad + share * motion.turn_rad)};
  const double s = share * motion.length_m;
  // A chord of length 2 sin(a) / k along the middle heading, a half of the angle.
  const double half = 0.5 * motion.curvature_1pm * s;
  const double chord = std::abs(half) < 1e-6 ? s : s * std::sin(half) / half;
  const double middle = from.yaw_rad + half;
  return {from.x_m + chord * std::cos(middle), from.y_m + chord * std::sin(middle), wrap_angle(middle + half)};
}

std::vector<Motions> connect_with_arcs(const Pose2& start, const Pose2& goal, double radius_m) {
  std::vector<Motions> ways;
  for (const auto& [s1, s2] : {std::pair(1, 1), std::pair(-1, -1), std::pair(1, -1), std::pair(-1, 1)}) {
    if (auto way = arc_straight_arc(start, goal, radius_m, s1, s2)) ways.push_back(std::move(*way));
  }
  sort_by_length(ways);
  return ways;
}

std::vector<Motions> connect_then_turn(const Pose2& start, const Pose2& goal, double radius_m) {
  std::vector<Motions> ways;
  for (const int s : {1, -1}) {
    if (auto way = arc_straight(start, goal, radius_m, s)) ways.push_back(std::move(*way));
  }
  sort_by_length(ways);
  return ways;
}

Motions turn_drive_turn(const Pose2& start, const Pose2& goal) {
  const Eigen::Vector2d d = goal.position_m() - start.position_m();
  Motions motions;
  if (d.norm() > kNothing) {
    append_turn(motions, start, std::atan2(d.y(), d.x()));
    append_drive(motions, start, d.norm(), 0);
  }
  append_turn(motions, start, goal.yaw_rad);
  return motions;
}

double length_of(const Motions& motions) {
  double sum = 0;
  for (const Motion& motion : motions) sum += motion.length_m;
  return sum;
}

}  // namespace arpent::planning
