// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/surface/voxel_classes.h"

#include "common/error.h"

namespace arpent::mapping {
namespace {

void classify(const Block& block, const TsdfParams& params, BlockClasses& classes) {
  const auto known_weight = static_cast<float>(params.known_weight), deep_m = static_cast<float>(-params.voxel_m);
  for (std::size_t z = 0; z < kBlockSide; ++z) {
    std::uint64_t known = 0, outside = 0, deep = 0;
    for (std::size_t i = 0; i < 64; ++i) {
      known |= static_cast<std::uint64_t>(block.weight[64 * z + i] >= known_weight ? 1 : 0) << i;
      outside |= static_cast<std::uint64_t>(block.distance_m[64 * z + i] > 0 ? 1 : 0) << i;
      deep |= static_cast<std::uint64_t>(block.distance_m[64 * z + i] < deep_m ? 1 : 0) << i;
    }
    classes.inferred[z] = known & deep;
    classes.empty[z] = known & outside;
    classes.occupied[z] = known & ~outside;
  }
}

}  // namespace

VoxelClasses::VoxelClasses() = default;
VoxelClasses::~VoxelClasses() = default;
VoxelClasses::VoxelClasses(VoxelClasses&&) noexcept = default;
VoxelClasses& VoxelClasses::operator=(VoxelClasses&&) noexcept = default;

void VoxelClasses::adopt(const BlockIndex& index) {
  auto fresh = std::make_unique<BlockClasses>();
  fresh->index = index;
  for (int n = 0; n < 27; ++n) {
    const BlockIndex offset(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
    const auto found = by_index_.find(index + offset);
    if (found == by_index_.end()) continue;
    fresh->around[static_cast<std::size_t>(n)] = found->second;
    found->second->around[static_cast<std::size_t>(26 - n)] = fresh.get();
  }
  fresh->around[kCentreOfAround] = fresh.get();
  by_index_.emplace(index, fresh.get());
  blocks_.push_back(std::move(fresh));
}

std::vector<std::size_t> VoxelClasses::update(const TsdfMap& map) {
  const TsdfMap::Storage& storage = map.storage();
  ARPENT_ASSERT(storage.blocks.size() >= blocks_.size() && storage.revision >= revision_);
  std::vector<std::size_t> touched;
  for (std::size_t i = 0; i < storage.blocks.size(); ++i) {
    const Block& block = *storage.blocks[i];
    const bool fresh = i >= blocks_.size();
    if (!fresh && block.revision <= revision_) continue;
    if (fresh) adopt(block.index);
    classify(block, storage.params, *blocks_[i]);
    touched.push_back(i);
  }
  revision_ = storage.revision;
  return touched;
}

const BlockClasses* VoxelClasses::find(const BlockIndex& index) const {
  const auto found = by_index_.find(index);
  return found == by_index_.end() ? nullptr : found->second;
}

VoxelClass VoxelClasses::at(const VoxelIndex& voxel) const {
  const BlockClasses* block = find(block_of(voxel));
  if (block == nullptr) return VoxelClass::kUnknown;
  const std::size_t offset = offset_in_block(voxel);
  if (bit_of(block->empty, offset)) return VoxelClass::kEmpty;
  return bit_of(block->occupied, offset) ? VoxelClass::kOccupied : VoxelClass::kUnknown;
}

}  // namespace arpent::mapping
