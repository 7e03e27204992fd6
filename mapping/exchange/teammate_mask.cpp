// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/teammate_mask.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace arpent::mapping {
namespace {

using Points = std::vector<Eigen::Vector2d>;

/// Of a box that crosses it, only what lies before this plane is in view.
constexpr double kNearM = 0.1;

std::array<Eigen::Vector3d, 8> corners_cam(const Pose& T_map_cam, const SeenTeammate& teammate,
                                           const TeammateMaskParams& params) {
  const double grow_m = params.margin_m + teammate.uncertainty_m;
  const Pose T_cam_body = T_map_cam.inverse() * teammate.body.to_pose();
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double x = ((i & 1) != 0 ? 1 : -1) * (params.half_length_m + grow_m);
    const double y = ((i & 2) != 0 ? 1 : -1) * (params.half_width_m + grow_m);
    // Not below the floor: what is seen there is floor, and where the box stands on it the floor is hidden.
    const double z = (i & 4) != 0 ? params.height_m + grow_m : 0.0;
    corners[i] = T_cam_body * Eigen::Vector3d(x, y, z);
  }
  return corners;
}

/// The box's corners in the image, and where its edges cross the near plane.
Points project(const std::array<Eigen::Vector3d, 8>& corners, const PinholeCamera& camera) {
  Points points;
  const auto add = [&](const Eigen::Vector3d& p) {
    points.emplace_back(camera.fx_px * p.x() / p.z() + camera.cx_px, camera.fy_px * p.y() / p.z() + camera.cy_px);
  };
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (corners[i].z() >= kNearM) add(corners[i]);
    for (const std::size_t bit : {1U, 2U, 4U}) {
      const Eigen::Vector3d &a = corners[i], &b = corners[i ^ bit];
      if (a.z() < kNearM && b.z() > kNearM) add(a + (kNearM - a.z()) / (b.z() - a.z()) * (b - a));
    }
  }
  return points;
}

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

/// A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", 1979: monotone chain.
Points convex_hull(Points points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  Points hull;
  if (points.size() < 3) return hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Eigen::Vector2d& p : points) {
      while (hull.size() >= base + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// The columns of one row that lie in the hull; empty (first > last) if none do.
std::pair<int, int> span_in(const Points& hull, int row, int cols) {
  double first = cols, last = -1;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d &a = hull[i], &b = hull[(i + 1) % hull.size()];
    if ((a.y() <= row) == (b.y() <= row)) continue;
    const double x = a.x() + (row - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    first = std::min(first, x);
    last = std::max(last, x);
  }
  return {static_cast<int>(std::ceil(std::max(0.0, first))),
          static_cast<int>(std::floor(std::min<double>(cols - 1, last)))};
}

}  // namespace

int mask_teammates(stereo::DepthMap& depth, const Pose& T_map_cam, std::span<const SeenTeammate> teammates,
                   const TeammateMaskParams& params) {
  int masked = 0;
  for (const SeenTeammate& teammate : teammates) {
    const Points hull = convex_hull(project(corners_cam(T_map_cam, teammate, params), depth.camera));
    if (hull.size() < 3) continue;
    for (int v = 0; v < depth.depth_m.rows; ++v) {
      const auto [first, last] = span_in(hull, v, depth.depth_m.cols);
      for (int u = first; u <= last; ++u) {
        masked += depth.depth_m(v, u) > 0 ? 1 : 0;
        depth.depth_m(v, u) = depth.sigma_m(v, u) = 0;
      }
    }
  }
  return masked;
}

}  // namespace arpent::mapping
