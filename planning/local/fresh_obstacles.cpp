// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/fresh_obstacles.h"

#include <algorithm>
#include <cmath>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::planning {
namespace {

/// Depth this much beyond a cell shows that it is empty.
constexpr double kPastM = 0.15;
/// What a body touches is at most so far from its rim: errors of the pose.
constexpr double kTouchM = 0.1;

bool is_depth(double z_m) {
  return z_m > 0 && std::isfinite(z_m);
}

/// Whether one of `cells` is this one or touches it: a surface on the border of two shows now in one, now in the other.
bool has_near(const std::set<GroundGrid::Cell>& cells, const GroundGrid::Cell& cell) {
  for (int dx = -1; dx <= 1; ++dx) {
    for (int dy = -1; dy <= 1; ++dy) {
      if (cells.contains({cell.first + dx, cell.second + dy})) return true;
    }
  }
  return false;
}

}  // namespace

FreshObstacles::FreshObstacles(const FreshObstacleParams& params) : params_(params) {
  config::check(params, "fresh obstacles");
  if (params.min_height_m >= params.max_height_m) {
    throw InputError("fresh obstacles: min_height_m must be below max_height_m");
  }
}

void FreshObstacles::look(const stereo::DepthMap& depth, const Pose& T_map_cam, GroundGrid& grid) {
  std::set<Cell> shown = find(depth, T_map_cam, grid);
  for (const Cell& cell : shown) {
    if (has_near(last_, cell)) hold(cell, T_map_cam.translation().head<2>(), grid);
  }
  clear(shown, depth, T_map_cam, grid);
  last_ = std::move(shown);
}

void FreshObstacles::touch(const Footprint& body, const Pose2& pose, GroundGrid& grid) {
  const Eigen::Vector2d ahead(std::cos(pose.yaw_rad), std::sin(pose.yaw_rad));
  const Eigen::Vector2d reach_m = Eigen::Vector2d::Constant(body.long_m() + kTouchM);
  const Cell least = grid.cell_at(pose.position_m() - reach_m), most = grid.cell_at(pose.position_m() + reach_m);
  for (int i = least.first; i <= most.first; ++i) {
    for (int j = least.second; j <= most.second; ++j) {
      const Eigen::Vector2d p_m = grid.centre_m({i, j});
      if ((p_m - pose.position_m()).dot(ahead) <= 0 || body.contains(pose, p_m)) continue;
      if (body.contains(pose, p_m, kTouchM)) mark({i, j}, grid);
    }
  }
}

/// Cells of which the image shows enough to be no noise, and which the map takes for free ground.
std::set<FreshObstacles::Cell> FreshObstacles::find(const stereo::DepthMap& depth, const Pose& T_map_cam,
                                                    const GroundGrid& grid) const {
  std::map<Cell, double> shown_m2;
  for (int v = 0; v < depth.depth_m.rows; ++v) {
    for (int u = 0; u < depth.depth_m.cols; ++u) {
      const auto z = static_cast<double>(depth.depth_m(v, u));
      if (!is_depth(z) || z > params_.range_m) continue;
      const Eigen::Vector3d p = T_map_cam * depth.camera.unproject(u, v, z);
      if (p.z() < params_.min_height_m || p.z() > params_.max_height_m) continue;
      shown_m2[grid.cell_at(p.head<2>())] += z / depth.camera.fx_px * z / depth.camera.fy_px;
    }
  }
  std::set<Cell> found;
  for (const auto& [cell, area_m2] : shown_m2) {
    if (area_m2 < params_.least_extent_m * grid.frame().cell_m) continue;
    if (held_.contains(cell) || is_apart(cell, grid)) found.insert(found.end(), cell);
  }
  return found;
}

bool FreshObstacles::is_apart(const Cell& cell, const GroundGrid& grid) const {
  const int reach = static_cast<int>(std::ceil(params_.apart_m / grid.frame().cell_m));
  for (int dx = -reach; dx <= reach; ++dx) {
    for (int dy = -reach; dy <= reach; ++dy) {
      if (grid.mapped_state({cell.first + dx, cell.second + dy}) != CellState::kFree) return false;
    }
  }
  return true;
}

bool FreshObstacles::mark(const Cell& cell, GroundGrid& grid) {
  const bool is_new = held_.emplace(cell, 0).second;
  if (is_new) grid.mark(cell, true);
  return is_new;
}

void FreshObstacles::hold(const Cell& cell, const Eigen::Vector2d& eye_m, GroundGrid& grid) {
  if (!mark(cell, grid)) return;
  const double cell_m = grid.frame().cell_m;
  const Eigen::Vector2d centre_m = grid.centre_m(cell), ray = (centre_m - eye_m).normalized();
  // Lines of sight spread: two of them leave no gap to those of the next cell.
  for (const double side : {-0.5, 0.5}) {
    const Eigen::Vector2d beside_m = centre_m + side * cell_m * Eigen::Vector2d(-ray.y(), ray.x());
    for (double beyond_m = cell_m; beyond_m < params_.behind_m; beyond_m += cell_m) {
      const Cell behind = grid.cell_at(beside_m + beyond_m * ray);
      if (grid.mapped_state(behind) != CellState::kFree) break;
      mark(behind, grid);
    }
  }
}

void FreshObstacles::clear(const std::set<Cell>& shown, const stereo::DepthMap& depth, const Pose& T_map_cam,
                           GroundGrid& grid) {
  const Pose T_cam_map = T_map_cam.inverse();
  for (auto held = held_.begin(); held != held_.end();) {
    auto& [cell, past] = *held;
    if (shown.contains(cell)) {
      past = 0;
    } else if (sees_past(grid.centre_m(cell), depth, T_cam_map)) {
      ++past;
    }
    if (past < params_.clear_images) {
      ++held;
      continue;
    }
    grid.mark(cell, false);
    held = held_.erase(held);
  }
}

/// Along a ray low above the floor: from there on it soon ends on it, and what stands in the cell would be in its way.
bool FreshObstacles::sees_past(const Eigen::Vector2d& centre_m, const stereo::DepthMap& depth,
                               const Pose& T_cam_map) const {
  const Eigen::Vector3d p = T_cam_map * Eigen::Vector3d(centre_m.x(), centre_m.y(), params_.min_height_m);
  if (p.z() <= 0) return false;
  const Eigen::Vector2d pixel = depth.camera.project(p);
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  if (u < 0 || v < 0 || u >= depth.depth_m.cols || v >= depth.depth_m.rows) return false;
  const auto z = static_cast<double>(depth.depth_m(v, u));
  return is_depth(z) && z > p.z() + kPastM;
}

}  // namespace arpent::planning
