// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/sight.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace arpent::planning {
namespace {

using mapping::BlockClasses;
using mapping::VoxelClasses;

bool bit_at(const mapping::BlockBits& bits, const VoxelIndex& v) {
  return (bits[static_cast<std::size_t>(v.z() & 7)] >> ((v.x() & 7) + 8 * (v.y() & 7)) & 1) != 0;
}

}  // namespace

Trace trace(const VoxelClasses& classes, const Eigen::Vector3d& from_voxels, const Eigen::Vector3d& to_voxels,
            Inferred inferred) {
  // Amanatides and Woo, "A fast voxel traversal algorithm", Eurographics 1987, from one block to the next by its
  // pointers. Each axis has so many walls to cross and no more: rounding cannot lead past the end.
  constexpr std::array<int, 3> kStride = {1, 3, 9};
  VoxelIndex voxel = from_voxels.array().floor().cast<int>();
  const VoxelIndex last = to_voxels.array().floor().cast<int>();
  Eigen::Vector3i left = last - voxel;
  Eigen::Vector3d next = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()), spacing = next;
  for (int k = 0; k < 3; ++k) {
    if (left[k] == 0) continue;
    const double along = to_voxels[k] - from_voxels[k];
    spacing[k] = std::abs(1 / along);
    next[k] = (voxel[k] + (left[k] > 0 ? 1 : 0) - from_voxels[k]) / along;
  }
  const BlockClasses* block = classes.find(mapping::block_of(voxel));
  Trace met;
  double entered = 0;
  for (int steps = left.cwiseAbs().sum();; --steps) {
    if (block == nullptr || !bit_at(block->empty, voxel)) {
      met.occupied = block != nullptr && bit_at(block->occupied, voxel) &&
                     !(inferred == Inferred::kIsUnknown && bit_at(block->inferred, voxel));
      if (met.occupied) return met;
      met.clear_share = std::min(met.clear_share, entered);
    }
    if (steps == 0) return met;
    const int k = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    const int step = left[k] > 0 ? 1 : -1;
    entered = next[k];
    voxel[k] += step;
    left[k] -= step;
    next[k] = left[k] == 0 ? std::numeric_limits<double>::infinity() : next[k] + spacing[k];
    if ((voxel[k] & 7) != (step > 0 ? 0 : 7)) continue;
    const int side = mapping::kCentreOfAround + step * kStride[static_cast<std::size_t>(k)];
    block = block != nullptr ? block->around[static_cast<std::size_t>(side)] : classes.find(mapping::block_of(voxel));
  }
}

Sight::Sight(const LevelCamera& camera, const mapping::IncompleteSurface& surface, const mapping::TsdfMap& map,
             const VoxelSet& given_up)
    : camera_(camera),
      classes_(surface.classes()),
      voxel_m_(map.params().voxel_m),
      known_weight_(map.params().known_weight),
      elements_(surface.elements(map)),
      first_{0} {
  std::unordered_map<VoxelIndex, std::uint32_t, mapping::BlockHash> index_of;
  for (const auto& element : elements_) {
    for (const VoxelIndex& voxel : surface.unknown_beside(element.voxel, map)) {
      const auto [entry, fresh] = index_of.try_emplace(voxel, static_cast<std::uint32_t>(unknowns_.size()));
      if (fresh) {
        const auto seen = map.voxel(voxel);
        const double weight = seen ? static_cast<double>(seen->weight) : 0.0;
        // Never zero: a voxel a rounding short of known still needs a look.
        const double missing = std::max(map.params().known_weight - weight, 1e-6);
        const Eigen::Vector3d centre_m = map.centre_m(voxel);
        const double above_m = element.distance_m + element.normal.dot(centre_m - element.centre_m);
        unknowns_.push_back({voxel, centre_m, missing, given_up.contains(voxel), element.normal, above_m});
      }
      members_.push_back(entry->second);
    }
    first_.push_back(static_cast<std::uint32_t>(members_.size()));
  }
}

bool Sight::is_given_up(std::size_t element) const {
  const auto unknowns = unknowns_of(element);
  return std::any_of(unknowns.begin(), unknowns.end(), [&](std::uint32_t u) { return unknowns_[u].given_up; });
}

bool Sight::reaches(const CameraView& view, const Eigen::Vector3d& p_map_m, double stop_short_m, double unknown_reach_m,
                    Inferred inferred) const {
  // Nothing nearer than the least depth is seen: there the ray begins.
  const Eigen::Vector3d ray = p_map_m - view.position_m();
  const double begin = camera_.min_range_m / view.depth_m(p_map_m);
  const double end = 1 - stop_short_m / ray.norm();
  if (end <= begin) return true;
  const Trace met = trace(classes_, (view.position_m() + begin * ray) / voxel_m_,
                          (view.position_m() + end * ray) / voxel_m_, inferred);
  if (met.occupied) return false;
  return met.clear_share >= 1 || (1 - met.clear_share) * (end - begin) * ray.norm() <= unknown_reach_m;
}

std::vector<std::uint32_t> Sight::see_elements(const Pose2& pose) const {
  const CameraView view(camera_, pose);
  std::vector<std::uint32_t> seen;
  for (std::uint32_t i = 0; i < elements_.size(); ++i) {
    const Eigen::Vector3d& p = elements_[i].centre_m;
    if (view.contains(p) && reaches(view, p, 0, 0, Inferred::kBlocks)) seen.push_back(i);
  }
  return seen;
}

bool Sight::measures(const CameraView& view, const UnknownVoxel& unknown) const {
  if (unknown.above_surface_m <= 0) return true;
  // Per unit of the ray that ends in the voxel, the height above the plane falls by this much.
  const double fall_m = unknown.normal.dot(view.position_m() - unknown.centre_m);
  const double camera_above_m = unknown.above_surface_m + fall_m;
  return fall_m > 0 && view.depth_m(unknown.centre_m) * camera_above_m <= camera_.max_range_m * fall_m;
}

bool Sight::shows(const CameraView& view, const Eigen::Vector3d& centre_m, double unknown_reach_m) const {
  return view.contains(centre_m) && reaches(view, centre_m, voxel_m_, unknown_reach_m, Inferred::kBlocks);
}

bool Sight::may_show(const CameraView& view, const Eigen::Vector3d& centre_m) const {
  return view.contains(centre_m) && reaches(view, centre_m, voxel_m_, kAnyReachM, Inferred::kIsUnknown);
}

std::vector<Look> Sight::look_at_unknowns(const Pose2& pose, double unknown_reach_m,
                                          std::span<const std::uint8_t> wanted) const {
  const CameraView view(camera_, pose);
  std::vector<Look> looks;
  for (std::uint32_t i = 0; i < unknowns_.size(); ++i) {
    if (!wanted.empty() && wanted[i] == 0) continue;
    if (!measures(view, unknowns_[i]) || !shows(view, unknowns_[i].centre_m, unknown_reach_m)) continue;
    looks.push_back({i, static_cast<float>(share_of_look(view, unknowns_[i]))});
  }
  return looks;
}

}  // namespace arpent::planning
