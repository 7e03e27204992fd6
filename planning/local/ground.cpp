// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/ground.h"

#include <algorithm>
#include <cmath>

#include "common/config/config.h"
#include "common/error.h"
#include "planning/local/distance_transform.h"

namespace arpent::planning {
namespace {

/// A motion is looked at at least this often, however little room there is.
constexpr double kLeastStepM = 0.02;
constexpr double kCostStepM = 0.05;
/// Beyond it, which way round the base turns depends on noise.
constexpr double kEitherWayRad = 3.0;

}  // namespace

Ground::Ground(const GroundGrid& grid, const Footprint& footprint, const DriveCosts& costs)
    : Ground(grid.frame(), grid.states(), footprint, costs) {}

Ground::Ground(const GridFrame& frame, std::vector<CellState> states, const Footprint& footprint,
               const DriveCosts& costs)
    : frame_(frame), states_(std::move(states)), footprint_(footprint), costs_(costs) {
  config::check(costs, "drive costs");
  ARPENT_ASSERT(states_.size() == frame_.size());
  if (states_.empty()) return;
  std::vector<std::uint8_t> blocked(states_.size());
  for (std::size_t at = 0; at < states_.size(); ++at) blocked[at] = states_[at] == CellState::kFree ? 0 : 1;
  const auto squared = squared_distances(blocked, frame_.cols, frame_.rows);
  clearance_m_.resize(squared.size());
  const auto cell = static_cast<float>(frame_.cell_m);
  for (std::size_t at = 0; at < squared.size(); ++at) {
    clearance_m_[at] = std::max(0.0F, cell * (std::sqrt(static_cast<float>(squared[at])) - 0.5F));
  }
  weigh();
}

void Ground::weigh() {
  weights_.assign(clearance_m_.size(), 0);
  for (std::size_t at = 0; at < weights_.size(); ++at) {
    const auto clearance = static_cast<double>(clearance_m_[at]);
    if (clearance < footprint_.short_m()) continue;
    weights_[at] = static_cast<std::uint16_t>(std::lround(kWeightOne * weight_at(clearance)));
  }
}

double Ground::weight_at(double clearance_m) const {
  const double lacking = std::max(0.0, 1 - clearance_m / costs_.comfort_m);
  return 1 + costs_.clearance_weight * lacking * lacking;
}

CellState Ground::state(const Eigen::Vector2d& p_m) const {
  if (states_.empty()) return CellState::kUnknown;
  const Eigen::Vector2i cell = frame_.cell_of(p_m);
  return frame_.has(cell.x(), cell.y()) ? states_[frame_.at(cell.x(), cell.y())] : CellState::kUnknown;
}

double Ground::clearance_m(const Eigen::Vector2d& p_m) const {
  const double x = p_m.x() / frame_.cell_m - frame_.first.x() - 0.5;
  const double y = p_m.y() / frame_.cell_m - frame_.first.y() - 0.5;
  if (!(x >= 0 && y >= 0 && x < frame_.cols - 1 && y < frame_.rows - 1)) return 0;
  const int i = static_cast<int>(x), j = static_cast<int>(y);
  const double tx = x - i, ty = y - j;
  const float* below = &clearance_m_[frame_.at(i, j)];
  const float* above = below + frame_.cols;
  const auto mix = [](float a, float b, double t) {
    return static_cast<double>(a) + t * (static_cast<double>(b) - static_cast<double>(a));
  };
  const double low = mix(below[0], below[1], tx), high = mix(above[0], above[1], tx);
  return low + ty * (high - low);
}

double Ground::margin_m(const Pose2& pose) const {
  const double at_centre = clearance_m(pose.position_m());
  // Far from everything and deep inside of something the discs would say the same.
  if (at_centre > 2 * footprint_.long_m()) return at_centre - footprint_.long_m();
  if (at_centre <= 0) return -footprint_.short_m();
  const Eigen::Vector2d ahead(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  double margin = at_centre;
  for (const FootprintDisc& disc : footprint_.discs()) {
    margin = std::min(margin, clearance_m(pose.position_m() + disc.along_m * ahead) - disc.radius_m);
  }
  return margin;
}

std::optional<double> Ground::first_contact(const Motion& motion, double slack_m) const {
  if (motion.is_turn() && std::abs(motion.turn_rad) > kEitherWayRad) {
    Motion half = motion;
    for (const double turn : {std::numbers::pi, -std::numbers::pi}) {
      half.turn_rad = turn * kEitherWayRad / std::numbers::pi;
      if (const auto contact = first_contact(half, slack_m)) return contact;
    }
    return std::nullopt;
  }
  // No point of the footprint moves farther than this.
  const double sweep_m = motion.is_turn()
                             ? std::abs(motion.turn_rad) * footprint_.long_m()
                             : motion.length_m * (1 + std::abs(motion.curvature_1pm) * footprint_.long_m());
  for (double share = 0;;) {
    const double margin = margin_m(pose_at(motion, share));
    if (margin < -slack_m) return share;
    if (share >= 1) return std::nullopt;
    share = std::min(1.0, share + std::max(margin + slack_m, kLeastStepM) / std::max(sweep_m, 1e-9));
  }
}

double Ground::cost_of(const Motion& motion) const {
  if (motion.is_turn()) return costs_.stop_m + costs_.turn_m_per_rad * std::abs(motion.turn_rad);
  const int steps = std::max(1, static_cast<int>(std::ceil(motion.length_m / kCostStepM)));
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    sum += weight_at(clearance_m(pose_at(motion, (i + 0.5) / steps).position_m()));
  }
  return sum / steps * motion.length_m;
}

double Ground::cost_of(const Motions& motions) const {
  double sum = 0;
  for (const Motion& motion : motions) sum += cost_of(motion);
  return sum;
}

}  // namespace arpent::planning
