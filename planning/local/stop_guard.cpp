// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/stop_guard.h"

#include <algorithm>
#include <cmath>

#include "common/config/config.h"
#include "common/error.h"
#include "planning/local/motion.h"

namespace arpent::planning {
namespace {

constexpr double kStepM = 0.04;
/// Slower than this the base turns rather than drives.
constexpr double kCreepMps = 0.02;

/// What the base sweeps before it stands, as poses in body coordinates, and the way to each.
struct Swept {
  std::vector<Pose2> poses;
  double length_m = 0;
};

Swept sweep_of(const StopGuardParams& params, const Footprint& footprint, const Twist2& twist) {
  const double v = twist.speed_mps, w = twist.turn_rate_radps;
  Motion motion;
  Swept swept;
  if (v > kCreepMps) {
    swept.length_m = v * v / (2 * params.deceleration_mps2) + params.delay_s * v + params.margin_m;
    motion = drive({}, swept.length_m, w / v);
  } else {
    const double angle = w * w / (2 * params.turn_deceleration_radps2) + params.delay_s * std::abs(w);
    motion.turn_rad = std::copysign(std::min(angle, std::numbers::pi), w);
    swept.length_m = std::abs(motion.turn_rad) * footprint.long_m();
  }
  const int steps = 1 + static_cast<int>(std::ceil(swept.length_m / kStepM));
  for (int i = 0; i <= steps; ++i) swept.poses.push_back(pose_at(motion, static_cast<double>(i) / steps));
  return swept;
}

}  // namespace

StopGuard::StopGuard(const StopGuardParams& params, const Footprint& footprint)
    : params_(params), footprint_(footprint) {
  config::check(params, "stop guard");
  if (params.min_height_m >= params.max_height_m) {
    throw InputError("stop guard: min_height_m must be below max_height_m");
  }
}

StopDecision StopGuard::look(const stereo::DepthMap& depth, const Pose& T_body_cam, const Twist2& twist) {
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < depth.depth_m.rows; v += params_.stride_px) {
    for (int u = 0; u < depth.depth_m.cols; u += params_.stride_px) {
      const auto z = static_cast<double>(depth.depth_m(v, u));
      if (z > 0 && std::isfinite(z)) points.push_back(T_body_cam * depth.camera.unproject(u, v, z));
    }
  }
  return look(points, twist);
}

StopDecision StopGuard::look(std::span<const Eigen::Vector3d> points_body_m, const Twist2& twist) {
  ARPENT_ASSERT(twist.finite());
  StopDecision decision;
  const Swept swept = sweep_of(params_, footprint_, twist);
  decision.looked_at_m = swept.length_m;
  decision.free_m = swept.length_m;
  const double reach_m = swept.length_m + footprint_.long_m() + params_.side_margin_m;
  std::vector<int> met_at(swept.poses.size(), 0);
  for (const Eigen::Vector3d& p : points_body_m) {
    if (p.z() < params_.min_height_m || p.z() > params_.max_height_m) continue;
    if (p.head<2>().squaredNorm() > reach_m * reach_m) continue;
    const auto met = std::find_if(swept.poses.begin(), swept.poses.end(), [&](const Pose2& pose) {
      return footprint_.contains(pose, p.head<2>(), params_.side_margin_m);
    });
    if (met != swept.poses.end()) ++met_at[static_cast<std::size_t>(met - swept.poses.begin())];
  }
  bool blocked = false;
  for (std::size_t i = 0; i < met_at.size(); ++i) {
    decision.points += met_at[i];
    if (blocked || decision.points < params_.min_points) continue;
    blocked = true;
    decision.free_m = swept.length_m * static_cast<double>(i) / static_cast<double>(met_at.size() - 1);
  }
  clear_ = blocked ? 0 : clear_ + 1;
  stopped_ = blocked || (stopped_ && clear_ < params_.clear_images);
  decision.stop = stopped_;
  return decision;
}

}  // namespace arpent::planning
