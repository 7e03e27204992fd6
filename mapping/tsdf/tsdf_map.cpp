// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/tsdf_map.h"

#include <cmath>
#include <span>

#include "common/config/config.h"
#include "common/crc32c.h"
#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

std::uint32_t checksum(const Block& block) {
  const std::array<std::int32_t, 3> index{block.index.x(), block.index.y(), block.index.z()};
  std::uint32_t crc = crc32c_of(std::span<const std::int32_t>(index));
  crc = crc32c_of(std::span<const float>(block.distance_m), crc);
  return crc32c_of(std::span<const float>(block.weight), crc);
}

}  // namespace

void TsdfMap::Storage::adopt(std::unique_ptr<Block> block) {
  if (blocks.size() >= static_cast<std::size_t>(params.max_blocks)) {
    ++refused_blocks;
    return;
  }
  by_index.emplace(block->index, block.get());
  blocks.push_back(std::move(block));
}

TsdfMap::TsdfMap(const TsdfParams& params) : storage_(std::make_unique<Storage>()) {
  config::check(params, "map");
  storage_->params = params;
}

TsdfMap::~TsdfMap() = default;
TsdfMap::TsdfMap(TsdfMap&&) noexcept = default;
TsdfMap& TsdfMap::operator=(TsdfMap&&) noexcept = default;

const TsdfParams& TsdfMap::params() const {
  return storage_->params;
}
TsdfMap::Storage& TsdfMap::storage() {
  return *storage_;
}
const TsdfMap::Storage& TsdfMap::storage() const {
  return *storage_;
}

std::optional<Voxel> TsdfMap::voxel(const VoxelIndex& index) const {
  const Block* block = storage_->find(block_of(index));
  if (block == nullptr) return std::nullopt;
  const std::size_t at = offset_in_block(index);
  if (block->weight[at] <= 0) return std::nullopt;
  return Voxel{block->distance_m[at], block->weight[at]};
}

bool TsdfMap::is_known(const VoxelIndex& index) const {
  const Block* block = storage_->find(block_of(index));
  return block != nullptr && block->weight[offset_in_block(index)] >= static_cast<float>(storage_->params.known_weight);
}

VoxelIndex TsdfMap::index_of(const Eigen::Vector3d& p_map_m) const {
  return (p_map_m / storage_->params.voxel_m).array().floor().cast<int>();
}

Eigen::Vector3d TsdfMap::centre_m(const VoxelIndex& index) const {
  return (index.cast<double>().array() + 0.5) * storage_->params.voxel_m;
}

std::size_t TsdfMap::block_count() const {
  return storage_->blocks.size();
}
std::int64_t TsdfMap::refused_blocks() const {
  return storage_->refused_blocks;
}
std::int64_t TsdfMap::revision() const {
  return storage_->revision;
}

std::size_t TsdfMap::known_voxel_count() const {
  std::size_t known = 0;
  for (const auto& block : storage_->blocks) known += static_cast<std::size_t>(block->known);
  return known;
}

std::uint32_t TsdfMap::digest() {
  for (const auto& block : storage_->blocks) {
    if (!block->checksum_stale) continue;
    const std::uint32_t now = checksum(*block);
    storage_->digest += now - block->checksum;  // a sum does not depend on the order of the blocks
    block->checksum = now;
    block->checksum_stale = false;
  }
  return storage_->digest;
}

}  // namespace arpent::mapping
