// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/query.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

/// Reads voxels; neighbouring ones mostly lie in one block, which is looked up once.
class Reader {
 public:
  explicit Reader(const TsdfMap& map) : map_(map.storage()) {}

  [[nodiscard]] std::optional<Voxel> at(const VoxelIndex& index) {
    const BlockIndex block = block_of(index);
    if (!looked_up_ || block != index_) {
      index_ = block;
      block_ = map_.find(block);
      looked_up_ = true;
    }
    if (block_ == nullptr) return std::nullopt;
    const std::size_t offset = offset_in_block(index);
    if (block_->weight[offset] <= 0) return std::nullopt;
    return Voxel{block_->distance_m[offset], block_->weight[offset]};
  }

 private:
  const TsdfMap::Storage& map_;
  BlockIndex index_ = BlockIndex::Zero();
  const Block* block_ = nullptr;
  bool looked_up_ = false;
};

std::optional<double> interpolate(Reader& reader, const Eigen::Vector3d& p_voxels) {
  const Eigen::Vector3d corner = (p_voxels.array() - 0.5).floor();
  const Eigen::Vector3d t = p_voxels - corner - Eigen::Vector3d::Constant(0.5);
  const VoxelIndex base = corner.cast<int>();
  double sum = 0;
  for (int n = 0; n < 8; ++n) {
    const VoxelIndex offset(n & 1, n >> 1 & 1, n >> 2);
    const auto voxel = reader.at(base + offset);
    if (!voxel) return std::nullopt;
    double weight = 1;
    for (int k = 0; k < 3; ++k) weight *= offset[k] == 1 ? t[k] : 1 - t[k];
    sum += weight * static_cast<double>(voxel->distance_m);
  }
  return sum;
}

/// Gradient of the distance at a voxel by differences to those neighbours that were seen; zero if there are none.
Eigen::Vector3d gradient_at(Reader& reader, const VoxelIndex& index, double here) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const VoxelIndex step = VoxelIndex::Unit(k);
    const auto after = reader.at(index + step);
    const auto before = reader.at(index - step);
    if (!after && !before) continue;
    const double spacing = after && before ? 2 : 1;
    gradient[k] = ((after ? static_cast<double>(after->distance_m) : here) -
                   (before ? static_cast<double>(before->distance_m) : here)) /
                  spacing;
  }
  return gradient;
}

/// One ray through the lattice, lengths in voxels.
class Walk {
 public:
  Walk(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) : voxel_(origin.array().floor().cast<int>()) {
    for (int k = 0; k < 3; ++k) {
      step_[k] = direction[k] > 0 ? 1 : -1;
      const double wall = voxel_[k] + (direction[k] > 0 ? 1.0 : 0.0);
      const bool along = direction[k] != 0;
      spacing_[k] = along ? std::abs(1 / direction[k]) : std::numeric_limits<double>::infinity();
      next_[k] = along ? (wall - origin[k]) / direction[k] : std::numeric_limits<double>::infinity();
    }
  }
  [[nodiscard]] const VoxelIndex& voxel() const { return voxel_; }
  [[nodiscard]] double entered() const { return entered_; }
  [[nodiscard]] double left() const { return next_.minCoeff(); }
  void advance() {
    Eigen::Index axis = 0;
    entered_ = next_.minCoeff(&axis);
    voxel_[axis] += step_[axis];
    next_[axis] += spacing_[axis];
  }

 private:
  VoxelIndex voxel_;
  Eigen::Vector3i step_;
  Eigen::Vector3d spacing_, next_;
  double entered_ = 0;
};

/// Where the interpolated distance passes zero between `before` (outside) and `after` on the ray; `otherwise` if the
/// field has gaps there.
double find_zero(Reader& reader, const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double before,
                 double after, double otherwise) {
  constexpr int kHalvings = 8;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (before + after);
    const auto d = interpolate(reader, origin + middle * direction);
    if (!d) return otherwise;
    (*d > 0 ? before : after) = middle;
  }
  return 0.5 * (before + after);
}

}  // namespace

std::optional<double> interpolate_distance_m(const TsdfMap& map, const Eigen::Vector3d& p_map_m) {
  Reader reader(map);
  return interpolate(reader, p_map_m / map.params().voxel_m);
}

std::optional<double> nearest_surface_m(const TsdfMap& map, const Eigen::Vector3d& p_map_m, double reach_m) {
  const double voxel = map.params().voxel_m;
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(reach_m + voxel);
  const BlockIndex least = block_of(map.index_of(p_map_m - reach));
  const BlockIndex most = block_of(map.index_of(p_map_m + reach));
  Reader reader(map);
  double nearest = std::numeric_limits<double>::infinity();
  for (int z = least.z(); z <= most.z(); ++z) {
    for (int y = least.y(); y <= most.y(); ++y) {
      for (int x = least.x(); x <= most.x(); ++x) {
        const Block* block = map.storage().find({x, y, z});
        if (block == nullptr) continue;
        for (int i = 0; i < kBlockVoxels; ++i) {
          const auto at = static_cast<std::size_t>(i);
          const auto d = static_cast<double>(block->distance_m[at]);
          if (!(block->weight[at] > 0) || std::abs(d) > voxel) continue;
          const VoxelIndex index = block->index * kBlockSide + VoxelIndex(i & 7, i >> 3 & 7, i >> 6);
          const Eigen::Vector3d gradient = gradient_at(reader, index, d);
          if (gradient.squaredNorm() <= 0) continue;
          const Eigen::Vector3d on_surface = map.centre_m(index) - d * gradient.normalized();
          nearest = std::min(nearest, (on_surface - p_map_m).norm());
        }
      }
    }
  }
  return nearest <= reach_m ? std::optional(nearest) : std::nullopt;
}

RayHit cast_ray(const TsdfMap& map, const Eigen::Vector3d& origin_map_m, const Eigen::Vector3d& direction,
                double max_range_m, double min_weight) {
  ARPENT_ASSERT(origin_map_m.allFinite() && std::abs(direction.norm() - 1) < 1e-6);
  const double voxel = map.params().voxel_m;
  const Eigen::Vector3d origin = origin_map_m / voxel;
  const double max_range = max_range_m / voxel;
  Reader reader(map);
  Walk walk(origin, direction);
  double middle_before = 0;
  for (; walk.entered() < max_range; walk.advance()) {
    const auto here = reader.at(walk.voxel());
    if (!here || static_cast<double>(here->weight) < min_weight) {
      return {RayEnd::kUnknown, walk.entered() * voxel, walk.voxel()};
    }
    const double middle = 0.5 * (walk.entered() + walk.left());
    if (here->distance_m <= 0) {
      const double range =
          find_zero(reader, origin, direction, std::max(middle_before - 0.5, 0.0), walk.left() + 0.5, middle);
      return {RayEnd::kSurface, std::min(range, max_range) * voxel, walk.voxel()};
    }
    middle_before = middle;
  }
  return {RayEnd::kFree, max_range_m, walk.voxel()};
}

}  // namespace arpent::mapping
