// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What planning needs of the map, one bit a voxel: empty, occupied or unknown (thesis Sect. 2.4.1), with blocks that
// know their neighbours. Kept up to date block by block; a walk or a dilation over it never touches the map itself.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "mapping/tsdf/storage.h"
#include "mapping/tsdf/tsdf_map.h"

namespace arpent::mapping {

enum class VoxelClass : std::uint8_t { kUnknown, kEmpty, kOccupied };

/// One bit per voxel of a block: voxel (x, y, z) is bit x + 8 y of word z.
using BlockBits = std::array<std::uint64_t, kBlockSide>;

[[nodiscard]] inline bool bit_of(const BlockBits& bits, std::size_t offset) {
  return (bits[offset >> 6] >> (offset & 63) & 1) != 0;
}

struct BlockClasses {
  BlockIndex index;
  BlockBits empty{};     ///< weight >= W_th and distance > 0
  BlockBits occupied{};  ///< weight >= W_th and distance <= 0
  /// Of the occupied ones, those more than a voxel below the surface. That there is matter was never measured: behind a
  /// corner the depth of the surface before it says the same of free space.
  BlockBits inferred{};
  /// The block at index + (dx, dy, dz), each in {-1, 0, 1}, is at (dx + 1) + 3 ((dy + 1) + 3 (dz + 1)); null if the map
  /// has none there. 13 is the block itself.
  std::array<const BlockClasses*, 27> around{};
};

inline constexpr int kCentreOfAround = 13;

class VoxelClasses {
 public:
  VoxelClasses();
  ~VoxelClasses();
  VoxelClasses(VoxelClasses&&) noexcept;
  VoxelClasses& operator=(VoxelClasses&&) noexcept;

  /// Takes over what changed in the map since the last call, always of the same map: blocks are never taken out of one.
  /// Returns the positions in blocks() of those that the map touched.
  std::vector<std::size_t> update(const TsdfMap& map);

  /// In the map's own order of creation.
  [[nodiscard]] const std::vector<std::unique_ptr<BlockClasses>>& blocks() const { return blocks_; }
  /// null if the map has no such block.
  [[nodiscard]] const BlockClasses* find(const BlockIndex& index) const;
  [[nodiscard]] VoxelClass at(const VoxelIndex& voxel) const;

 private:
  void adopt(const BlockIndex& index);

  std::vector<std::unique_ptr<BlockClasses>> blocks_;
  std::unordered_map<BlockIndex, BlockClasses*, BlockHash> by_index_;
  std::int64_t revision_ = -1;
};

}  // namespace arpent::mapping
