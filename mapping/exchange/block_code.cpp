// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/block_code.h"

#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <unordered_set>

#include "common/error.h"

namespace arpent::mapping {
namespace {

// A sample, uncompressed: number of blocks (u16), their indices (3 x i32 each), then for all blocks the weights, then
// for all blocks the distances: one byte a voxel, each the difference to the voxel before it in the block.
using Buffer = std::vector<std::uint8_t>;

constexpr int kDistanceSteps = 127;
constexpr float kWeightStepsPerOctave = 16.0F;
constexpr int kCompressionLevel = 9;
constexpr std::size_t kIndexBytes = 12;
constexpr std::size_t kBlockBytes = kIndexBytes + 2 * kBlockVoxels;
constexpr std::size_t kMaxBlocks = 4096;
constexpr int kMaxIndex = 1 << 20;

std::uint8_t weight_code(float weight) {
  if (weight <= 0) return 0;
  const auto step = std::lround(std::log2(weight / kLeastCodedWeight) * kWeightStepsPerOctave);
  return static_cast<std::uint8_t>(std::clamp<long>(1 + step, 1, 255));
}

float weight_value(std::uint8_t code) {
  return code == 0 ? 0.0F : kLeastCodedWeight * std::exp2(static_cast<float>(code - 1) / kWeightStepsPerOctave);
}

/// What lies on the empty side of the surface stays there.
std::uint8_t distance_code(float distance_m, float truncation_m) {
  const auto step = std::lround(std::clamp(distance_m / truncation_m, -1.0F, 1.0F) * kDistanceSteps);
  return static_cast<std::uint8_t>(128 + (distance_m > 0 ? std::max<long>(1, step) : step));
}

float distance_value(std::uint8_t code, float truncation_m) {
  return static_cast<float>(code - 128) / kDistanceSteps * truncation_m;
}

Buffer compress(const Buffer& plain) {
  Buffer packed(ZSTD_compressBound(plain.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kCompressionLevel));
  return packed;
}

Buffer encode(std::span<const Block* const> blocks, float truncation_m) {
  Buffer plain;
  plain.reserve(2 + blocks.size() * kBlockBytes);
  const auto count = static_cast<std::uint16_t>(blocks.size());
  const auto append = [&](const auto& value) {
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
    plain.insert(plain.end(), bytes, bytes + sizeof(value));
  };
  append(count);
  for (const Block* block : blocks) {
    for (int axis = 0; axis < 3; ++axis) append(static_cast<std::int32_t>(block->index[axis]));
  }
  const auto append_plane = [&](const auto& code_of) {
    for (const Block* block : blocks) {
      std::uint8_t last = 0;
      for (std::size_t i = 0; i < kBlockVoxels; ++i) {
        const std::uint8_t code = code_of(*block, i);
        plain.push_back(static_cast<std::uint8_t>(code - last));
        last = code;
      }
    }
  };
  append_plane([](const Block& block, std::size_t i) { return weight_code(block.weight[i]); });
  append_plane([&](const Block& block, std::size_t i) {
    return block.weight[i] > 0 ? distance_code(block.distance_m[i], truncation_m) : std::uint8_t{255};
  });
  return compress(plain);
}

/// The differences of one block summed up.
std::array<std::uint8_t, kBlockVoxels> sum_up(const std::uint8_t* differences) {
  std::array<std::uint8_t, kBlockVoxels> codes{};
  std::uint8_t sum = 0;
  for (std::size_t i = 0; i < kBlockVoxels; ++i) codes[i] = sum = static_cast<std::uint8_t>(sum + differences[i]);
  return codes;
}

Result<Buffer> decompress(std::span<const std::uint8_t> sample) {
  const unsigned long long size = ZSTD_getFrameContentSize(sample.data(), sample.size());
  if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size < 2 ||
      size > 2 + kMaxBlocks * kBlockBytes) {
    return Fault{"no sample of blocks"};
  }
  Buffer plain(size);
  if (ZSTD_decompress(plain.data(), plain.size(), sample.data(), sample.size()) != size) {
    return Fault{"a sample of blocks that is damaged"};
  }
  return plain;
}

}  // namespace

std::vector<Buffer> encode_blocks(std::span<const Block* const> blocks, float truncation_m, std::size_t max_bytes) {
  ARPENT_ASSERT(max_bytes >= 2 * kBlockBytes || max_bytes >= 2048);
  std::vector<Buffer> samples;
  std::size_t guess = 16;
  while (!blocks.empty()) {
    std::size_t count = std::clamp<std::size_t>(guess, 1, std::min(blocks.size(), kMaxBlocks));
    Buffer sample = encode(blocks.first(count), truncation_m);
    while (sample.size() > max_bytes) {
      count = std::max<std::size_t>(1, count * max_bytes * 9 / (sample.size() * 10));
      sample = encode(blocks.first(count), truncation_m);
    }
    guess = std::max<std::size_t>(1, count * max_bytes * 9 / (sample.size() * 10));
    blocks = blocks.subspan(count);
    samples.push_back(std::move(sample));
  }
  return samples;
}

Result<std::vector<BlockUpdate>> decode_blocks(std::span<const std::uint8_t> sample, float truncation_m) {
  const Result<Buffer> plain = decompress(sample);
  if (!plain) return Fault{plain.fault()};
  std::uint16_t count = 0;
  std::memcpy(&count, plain->data(), sizeof count);
  if (plain->size() != 2 + count * kBlockBytes) return Fault{"a sample with another number of blocks than it says"};
  const std::uint8_t* indices = plain->data() + 2;
  const std::uint8_t* weights = indices + count * kIndexBytes;
  const std::uint8_t* distances = weights + static_cast<std::size_t>(count) * kBlockVoxels;
  std::vector<BlockUpdate> updates(count);
  std::unordered_set<BlockIndex, BlockHash> seen;
  for (std::size_t b = 0; b < count; ++b) {
    BlockUpdate& update = updates[b];
    std::array<std::int32_t, 3> index{};
    std::memcpy(index.data(), indices + b * kIndexBytes, kIndexBytes);
    update.index = {index[0], index[1], index[2]};
    if (update.index.minCoeff() < -kMaxIndex || update.index.maxCoeff() > kMaxIndex) {
      return Fault{"a block too far away"};
    }
    if (!seen.insert(update.index).second) return Fault{"a block that comes twice"};
    const auto weight_codes = sum_up(weights + b * kBlockVoxels), distance_codes = sum_up(distances + b * kBlockVoxels);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      update.weight[i] = weight_value(weight_codes[i]);
      if (weight_codes[i] == 0) continue;
      if (distance_codes[i] == 0) return Fault{"a distance that does not exist"};
      update.distance_m[i] = distance_value(distance_codes[i], truncation_m);
    }
  }
  return updates;
}

}  // namespace arpent::mapping
