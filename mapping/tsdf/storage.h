// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How the map lies in memory: blocks of 8 x 8 x 8 voxels, found by a hash of their index, created where depth reaches.
// For the parts of mapping/ only; others use TsdfMap.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "mapping/tsdf/tsdf_map.h"

namespace arpent::mapping {

inline constexpr int kBlockSide = 8;
inline constexpr int kBlockVoxels = kBlockSide * kBlockSide * kBlockSide;

using BlockIndex = Eigen::Vector3i;  ///< block (i, j, k) holds voxels 8 i .. 8 i + 7 and so on

struct BlockHash {
  std::size_t operator()(const BlockIndex& b) const {
    std::uint64_t h = static_cast<std::uint32_t>(b.x()) * 0x9E3779B97F4A7C15ULL;
    h = (h ^ (h >> 29)) + static_cast<std::uint32_t>(b.y()) * 0xBF58476D1CE4E5B9ULL;
    h = (h ^ (h >> 31)) + static_cast<std::uint32_t>(b.z()) * 0x94D049BB133111EBULL;
    return static_cast<std::size_t>(h ^ (h >> 30));
  }
};

/// Voxel (x, y, z) of the block is at x + 8 (y + 8 z).
struct Block {
  BlockIndex index;
  std::array<float, kBlockVoxels> distance_m{};
  std::array<float, kBlockVoxels> weight{};
  std::int64_t revision = 0;   ///< of the last integration that touched it
  int known = 0;               ///< voxels with weight >= W_th
  std::uint32_t checksum = 0;  ///< CRC-32C of index, distances and weights when last asked
  bool checksum_stale = true;
};

[[nodiscard]] inline int floor_div8(int v) {
  return v >> 3;
}
[[nodiscard]] inline BlockIndex block_of(const VoxelIndex& v) {
  return {floor_div8(v.x()), floor_div8(v.y()), floor_div8(v.z())};
}
[[nodiscard]] inline std::size_t offset_in_block(const VoxelIndex& v) {
  return static_cast<std::size_t>((v.x() & 7) + kBlockSide * ((v.y() & 7) + kBlockSide * (v.z() & 7)));
}

struct TsdfMap::Storage {
  TsdfParams params;
  std::vector<std::unique_ptr<Block>> blocks;  ///< in order of creation
  std::unordered_map<BlockIndex, Block*, BlockHash> by_index;
  std::int64_t revision = 0;
  std::int64_t refused_blocks = 0;  ///< not created because of max_blocks
  std::uint32_t digest = 0;         ///< sum of the blocks' checksums

  [[nodiscard]] double truncation_m() const { return params.truncation_voxels * params.voxel_m; }
  [[nodiscard]] double block_edge_m() const { return kBlockSide * params.voxel_m; }
  [[nodiscard]] const Block* find(const BlockIndex& index) const {
    const auto found = by_index.find(index);
    return found == by_index.end() ? nullptr : found->second;
  }
  /// Takes a block that is not there yet; refused and counted if the map is full.
  void adopt(std::unique_ptr<Block> block);
};

}  // namespace arpent::mapping
