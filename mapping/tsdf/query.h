// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Questions to the map: how far is the surface from here, and what does a ray meet. For planning (gain, clearance) and
// for rendering the map; nothing is changed.
#pragma once

#include <optional>

#include "mapping/tsdf/tsdf_map.h"

namespace arpent::mapping {

/// Signed distance at a point, trilinear between the eight voxels around it; nullopt if one of them was never seen.
/// Positive in empty space, at most the truncation distance.
[[nodiscard]] std::optional<double> interpolate_distance_m(const TsdfMap& map, const Eigen::Vector3d& p_map_m);

/// Distance from a point to the nearest surface seen so far, on either side of it; nullopt if there is none within
/// `reach_m`. Exact up to the map's own error, beyond the truncation distance too: it looks at all voxels beside a
/// surface within reach, so keep the reach small (cost grows with its cube).
[[nodiscard]] std::optional<double> nearest_surface_m(const TsdfMap& map, const Eigen::Vector3d& p_map_m,
                                                      double reach_m);

enum class RayEnd : std::uint8_t {
  kSurface,  ///< met a surface
  kUnknown,  ///< met a voxel whose weight is below the threshold
  kFree,     ///< reached the greatest range through empty space
};

struct RayHit {
  RayEnd end = RayEnd::kFree;
  double range_m = 0;  ///< along the ray to the surface (interpolated), or to where the last voxel is entered
  VoxelIndex voxel = VoxelIndex::Zero();  ///< the last one
};

/// Walks voxel by voxel (Amanatides and Woo, "A fast voxel traversal algorithm", Eurographics 1987) from `origin_map_m`
/// along the unit vector `direction`. Voxels that weigh less than `min_weight` are unknown; any seen voxel is known
/// with 0. Throws nothing; a direction that is not a unit vector or a point that is not finite is a programmer's
/// mistake.
[[nodiscard]] RayHit cast_ray(const TsdfMap& map, const Eigen::Vector3d& origin_map_m, const Eigen::Vector3d& direction,
                              double max_range_m, double min_weight);

}  // namespace arpent::mapping
