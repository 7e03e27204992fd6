// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/recovery.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace arpent::planning {
namespace {

constexpr double kSpacingM = 0.03;
constexpr double kSpacingRad = 0.1;
constexpr double kLeastBackM = 0.3;
constexpr double kLeastBackOffM = 0.1;
constexpr double kPathSpacingM = 0.05;  ///< as control::Path takes them
constexpr int kHeadings = 36;
/// Less than half turns, so that the tracker knows which way round.
constexpr int kTurnsAbout = 3;
/// Nearer than this a recovery was tried at the same place.
constexpr double kSamePlaceM = 0.1;
constexpr double kSameHeadingRad = 0.3;

std::optional<Motion> find_turn(const Ground& ground, const Pose2& pose, double deepest_m,
                                const RecoveryParams& params) {
  for (int i = 1; i <= kHeadings / 2; ++i) {
    for (const int side : {1, -1}) {
      const Motion turn = turn_to(pose, pose.yaw_rad + side * i * 2 * std::numbers::pi / kHeadings);
      if (ground.margin_m(end_of(turn)) >= params.room_m && !ground.first_contact(turn, deepest_m)) return turn;
    }
  }
  return std::nullopt;
}

/// A quarter of a circle to one side at least: then every direction is near for one end or the other.
bool can_turn_about(const Ground& ground, const Pose2& pose) {
  return !ground.first_contact({pose, 0, 0, 0.5 * std::numbers::pi}) ||
         !ground.first_contact({pose, 0, 0, -0.5 * std::numbers::pi});
}

}  // namespace

void Trail::add(const Pose2& pose) {
  if (!poses_.empty()) {
    const Pose2& last = poses_.back();
    if ((last.position_m() - pose.position_m()).norm() < kSpacingM &&
        std::abs(wrap_angle(last.yaw_rad - pose.yaw_rad)) < kSpacingRad) {
      return;
    }
  }
  poses_.push_back(pose);
  double length_m = 0;
  for (std::size_t i = poses_.size() - 1; i > 0; --i) {
    length_m += (poses_[i].position_m() - poses_[i - 1].position_m()).norm();
    if (length_m <= length_m_) continue;
    poses_.erase(poses_.begin(), poses_.begin() + static_cast<std::ptrdiff_t>(i));
    return;
  }
}

std::optional<Recovery> plan_recovery(const Ground& ground, const Pose2& pose, const Trail& trail,
                                      const RecoveryParams& params) {
  const double deepest_m = std::max(0.0, -ground.margin_m(pose)) + params.max_deeper_m;
  if (const auto turn = find_turn(ground, pose, deepest_m, params)) return Recovery{turn, {}};
  Recovery recovery;
  double driven_m = 0;
  Pose2 at = pose;
  for (auto back = trail.poses().rbegin(); back != trail.poses().rend(); ++back) {
    driven_m += (back->position_m() - at.position_m()).norm();
    if (driven_m > params.max_back_m || ground.margin_m(*back) < -deepest_m) break;
    recovery.backwards.push_back(*back);
    at = *back;
    if (ground.margin_m(at) >= params.room_m && can_turn_about(ground, at)) return recovery;
  }
  // No room to turn so far: at least out of the corner, if it is one.
  const bool some_way = (at.position_m() - pose.position_m()).norm() >= kLeastBackM;
  return some_way && ground.margin_m(at) >= params.room_m ? std::optional(recovery) : std::nullopt;
}

std::optional<Recovery> back_off(const Ground& ground, const Pose2& pose, const Trail& trail, double length_m,
                                 const RecoveryParams& params) {
  const double deepest_m = std::max(0.0, -ground.margin_m(pose)) + params.max_deeper_m;
  const Eigen::Vector2d back = -Eigen::Vector2d(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  Recovery straight;
  for (double way_m = kPathSpacingM; way_m <= length_m; way_m += kPathSpacingM) {
    const Eigen::Vector2d p = pose.position_m() + way_m * back;
    const Pose2 at{p.x(), p.y(), pose.yaw_rad};
    if (ground.margin_m(at) < -deepest_m) break;
    straight.backwards.push_back(at);
  }
  Recovery along;
  double driven_m = 0;
  Pose2 at = pose;
  for (auto behind = trail.poses().rbegin(); behind != trail.poses().rend() && driven_m < length_m; ++behind) {
    if (ground.margin_m(*behind) < -deepest_m) break;
    driven_m += (behind->position_m() - at.position_m()).norm();
    along.backwards.push_back(*behind);
    at = *behind;
  }
  const double straight_m = kPathSpacingM * static_cast<double>(straight.backwards.size());
  if (std::max(straight_m, driven_m) < kLeastBackOffM) return std::nullopt;
  return straight_m >= driven_m ? straight : along;
}

DrivePiece piece_of(const Recovery& recovery, const Pose2& pose) {
  if (recovery.turn) return pieces_of({pose, end_of(*recovery.turn), {*recovery.turn}, {}}).front();
  DrivePiece piece{{pose.position_m()}, recovery.backwards.back().yaw_rad, true};
  for (const Pose2& at : recovery.backwards) {
    if ((at.position_m() - piece.points_m.back()).norm() >= kPathSpacingM - 1e-6)
      piece.points_m.push_back(at.position_m());
  }
  if (piece.points_m.size() == 1) {
    // Only turns: as they came, but forwards.
    return pieces_of({pose, recovery.backwards.back(), {turn_to(pose, recovery.backwards.back().yaw_rad)}, {}}).front();
  }
  return piece;
}

std::vector<DrivePiece> turn_about(const Pose2& pose) {
  std::vector<DrivePiece> pieces;
  for (int k = 0; k < kTurnsAbout; ++k) {
    const double turn_rad = 2 * std::numbers::pi / kTurnsAbout;
    const Pose2 from{pose.x_m, pose.y_m, wrap_angle(pose.yaw_rad + k * turn_rad)};
    pieces.push_back(piece_of(Recovery{turn_to(from, from.yaw_rad + turn_rad), {}}, from));
  }
  return pieces;
}

bool TriedPoses::try_at(const Pose2& pose, int most) {
  const auto before = std::count_if(poses_.begin(), poses_.end(), [&](const Pose2& tried) {
    return (tried.position_m() - pose.position_m()).norm() < kSamePlaceM &&
           std::abs(wrap_angle(tried.yaw_rad - pose.yaw_rad)) < kSameHeadingRad;
  });
  if (before >= most) return false;
  poses_.push_back(pose);
  return true;
}

}  // namespace arpent::planning
