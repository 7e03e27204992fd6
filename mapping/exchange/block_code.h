// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Blocks of a map as few bytes, for the radio: distances to 1/127 of the truncation distance (their sign survives),
// weights to 1/16 octave, both as planes of differences, compressed with zstd. Coarser than the map's file and five
// times smaller; the mesh does not lose by it (8 bits: nothing measurable, docs/teams.md).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/result.h"
#include "mapping/tsdf/storage.h"

namespace arpent::mapping {

/// What one block adds to a map. Voxels of weight 0 say nothing.
struct BlockUpdate {
  BlockIndex index = BlockIndex::Zero();
  std::array<float, kBlockVoxels> distance_m{};
  std::array<float, kBlockVoxels> weight{};
};

/// Weights leave this range only by being clamped to it: 2^-10 to 2^5.9.
inline constexpr float kLeastCodedWeight = 0x1p-10F;

/// As many samples as it takes, none larger than `max_bytes` (at least 2048), each to be decoded by itself. Blocks in
/// the order given.
[[nodiscard]] std::vector<std::vector<std::uint8_t>> encode_blocks(std::span<const Block* const> blocks,
                                                                   float truncation_m, std::size_t max_bytes);

/// All of a sample or nothing: a fault if a byte makes no sense, a block comes twice or lies too far away to index.
[[nodiscard]] Result<std::vector<BlockUpdate>> decode_blocks(std::span<const std::uint8_t> sample, float truncation_m);

}  // namespace arpent::mapping
