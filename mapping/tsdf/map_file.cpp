// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/map_file.h"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <span>
#include <sstream>
#include <tuple>
#include <vector>

#include "common/atomic_file.h"
#include "common/crc32c.h"
#include "common/error.h"
#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

// File: header, then groups. All numbers little-endian. Group: {compressed bytes, blocks, CRC of the group's header},
// zstd data. Inside, block by block: index (3 x i32), CRC-32C of the quantised voxels; then, for all blocks of the
// group, the planes: distance high bytes, distance low bytes, weights.
constexpr char kMagic[8] = {'a', 'r', 'p', 'm', 'a', 'p', '0', '1'};
constexpr std::size_t kGroupBlocks = 16;
constexpr int kDistanceSteps = 2047;
constexpr float kWeightStepsPerOctave = 8.0F;
constexpr float kLeastWeightLog2 = -16.0F;
constexpr int kCompressionLevel = 6;
constexpr std::size_t kBlockHeaderBytes = 16;
constexpr std::size_t kBlockBytes = kBlockHeaderBytes + 3 * kBlockVoxels;

struct FileHeader {
  char magic[8];
  double voxel_m, known_weight, min_range_m, max_range_m, truncation_voxels, max_weight;
  std::uint64_t blocks;
  std::uint32_t crc;
  std::uint32_t reserved;
};
static_assert(sizeof(FileHeader) == 72);

struct GroupHeader {
  std::uint32_t bytes;
  std::uint32_t blocks;
  std::uint32_t crc;
};

using Buffer = std::vector<std::uint8_t>;

template <class T>
void append(Buffer& buffer, const T& value) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
  buffer.insert(buffer.end(), bytes, bytes + sizeof(T));
}

template <class T>
std::uint32_t header_crc(T header) {
  header.crc = 0;
  return crc32c(std::as_bytes(std::span(&header, 1)));
}

float weight_value(int code) {
  return std::exp2((static_cast<float>(code) - 1.0F) / kWeightStepsPerOctave + kLeastWeightLog2);
}

/// 0 is "never seen"; otherwise the nearest step on the same side of W_th.
std::uint8_t weight_code(float weight, float known_weight) {
  if (weight <= 0) return 0;
  int code = 1 + static_cast<int>(std::lround((std::log2(weight) - kLeastWeightLog2) * kWeightStepsPerOctave));
  code = std::clamp(code, 1, 255);
  while (code > 1 && weight < known_weight && weight_value(code) >= known_weight) --code;
  while (code < 255 && weight >= known_weight && weight_value(code) < known_weight) ++code;
  return static_cast<std::uint8_t>(code);
}

/// A block as 16-bit distances and 8-bit weights. The sign of the distance survives: it decides what is occupied.
struct Quantised {
  std::array<std::int16_t, kBlockVoxels> distance;
  std::array<std::uint8_t, kBlockVoxels> weight;

  [[nodiscard]] std::uint32_t crc() const {
    return crc32c_of(std::span<const std::uint8_t>(weight), crc32c_of(std::span<const std::int16_t>(distance)));
  }
};

Quantised quantise(const Block& block, float truncation_m, float known_weight) {
  Quantised q;
  for (std::size_t i = 0; i < kBlockVoxels; ++i) {
    q.weight[i] = weight_code(block.weight[i], known_weight);
    const float steps = block.distance_m[i] / truncation_m * kDistanceSteps;
    auto distance = static_cast<std::int16_t>(std::lround(std::clamp(steps, -2048.0F, 2047.0F)));
    if (distance == 0 && block.distance_m[i] > 0) distance = 1;
    q.distance[i] = q.weight[i] == 0 ? std::int16_t{0} : distance;
  }
  return q;
}

void restore(const Quantised& q, float truncation_m, float known_weight, Block& block) {
  block.known = 0;
  for (std::size_t i = 0; i < kBlockVoxels; ++i) {
    block.weight[i] = q.weight[i] == 0 ? 0.0F : weight_value(q.weight[i]);
    block.distance_m[i] = static_cast<float>(q.distance[i]) / kDistanceSteps * truncation_m;
    block.known += block.weight[i] >= known_weight ? 1 : 0;
  }
}

Buffer pack_group(std::span<const Block* const> blocks, float truncation_m, float known_weight) {
  Buffer plain;
  std::vector<Quantised> quantised;
  for (const Block* block : blocks) {
    quantised.push_back(quantise(*block, truncation_m, known_weight));
    for (int axis = 0; axis < 3; ++axis) append(plain, static_cast<std::int32_t>(block->index[axis]));
    append(plain, quantised.back().crc());
  }
  for (const Quantised& q : quantised) {
    for (const std::int16_t d : q.distance)
      plain.push_back(static_cast<std::uint8_t>(static_cast<std::uint16_t>(d) >> 8));
  }
  for (const Quantised& q : quantised) {
    for (const std::int16_t d : q.distance) plain.push_back(static_cast<std::uint8_t>(d & 0xFF));
  }
  for (const Quantised& q : quantised) plain.insert(plain.end(), q.weight.begin(), q.weight.end());
  Buffer packed(ZSTD_compressBound(plain.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), plain.data(), plain.size(), kCompressionLevel));
  return packed;
}

/// Adds the intact blocks of a group to the map; returns how many.
std::size_t unpack_group(std::span<const std::uint8_t> packed, std::size_t count, TsdfMap::Storage& map) {
  Buffer plain(count * kBlockBytes);
  if (ZSTD_decompress(plain.data(), plain.size(), packed.data(), packed.size()) != plain.size()) return 0;
  const std::uint8_t* high = plain.data() + count * kBlockHeaderBytes;
  const std::uint8_t* low = high + count * kBlockVoxels;
  const std::uint8_t* weights = low + count * kBlockVoxels;
  std::size_t intact = 0;
  for (std::size_t b = 0; b < count; ++b) {
    std::array<std::int32_t, 3> index{};
    std::uint32_t crc = 0;
    std::memcpy(index.data(), plain.data() + b * kBlockHeaderBytes, 12);
    std::memcpy(&crc, plain.data() + b * kBlockHeaderBytes + 12, 4);
    Quantised q;
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      const std::size_t at = b * kBlockVoxels + i;
      q.distance[i] = static_cast<std::int16_t>(static_cast<std::uint16_t>(high[at] << 8 | low[at]));
      q.weight[i] = weights[at];
    }
    auto block = std::make_unique<Block>();
    block->index = BlockIndex(index[0], index[1], index[2]);
    if (q.crc() != crc || map.find(block->index) != nullptr) continue;
    restore(q, static_cast<float>(map.truncation_m()), static_cast<float>(map.params.known_weight), *block);
    block->revision = 1;
    map.adopt(std::move(block));
    ++intact;
  }
  return intact;
}

std::vector<const Block*> in_order(const TsdfMap::Storage& map) {
  std::vector<const Block*> blocks;
  for (const auto& block : map.blocks) blocks.push_back(block.get());
  std::sort(blocks.begin(), blocks.end(), [](const Block* a, const Block* b) {
    return std::tuple(a->index.z(), a->index.y(), a->index.x()) < std::tuple(b->index.z(), b->index.y(), b->index.x());
  });
  return blocks;
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::stringstream text;
  if (!in || std::filesystem::is_directory(path) || !(text << in.rdbuf()))
    throw InputError(path.string() + ": cannot be read");
  return text.str();
}

}  // namespace

void save_map(const std::filesystem::path& path, const TsdfMap& map) {
  const TsdfMap::Storage& storage = map.storage();
  const std::vector<const Block*> blocks = in_order(storage);
  const auto truncation_m = static_cast<float>(storage.truncation_m());
  const auto known_weight = static_cast<float>(storage.params.known_weight);
  atomic_write(path, [&](const WriteBytes& write) {
    const TsdfParams& p = storage.params;
    FileHeader header{
        {}, p.voxel_m, p.known_weight, p.min_range_m, p.max_range_m, p.truncation_voxels, p.max_weight, blocks.size(),
        0,  0};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.crc = header_crc(header);
    write(std::as_bytes(std::span(&header, 1)));
    for (std::size_t first = 0; first < blocks.size(); first += kGroupBlocks) {
      const std::size_t count = std::min(kGroupBlocks, blocks.size() - first);
      const Buffer packed = pack_group(std::span(blocks).subspan(first, count), truncation_m, known_weight);
      GroupHeader group{static_cast<std::uint32_t>(packed.size()), static_cast<std::uint32_t>(count), 0};
      group.crc = header_crc(group);
      write(std::as_bytes(std::span(&group, 1)));
      write(std::as_bytes(std::span(packed)));
    }
  });
}

LoadedMap load_map(const std::filesystem::path& path) {
  const std::string content = read_file(path);
  FileHeader header{};
  if (content.size() < sizeof header) throw InputError(path.string() + ": is no map of ours");
  std::memcpy(&header, content.data(), sizeof header);
  if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0) throw InputError(path.string() + ": is no map of ours");
  if (header_crc(header) != header.crc) throw InputError(path.string() + ": the map's header is damaged");
  TsdfParams params;
  params.voxel_m = header.voxel_m;
  params.known_weight = header.known_weight;
  params.min_range_m = header.min_range_m;
  params.max_range_m = header.max_range_m;
  params.truncation_voxels = header.truncation_voxels;
  params.max_weight = header.max_weight;
  LoadedMap loaded{TsdfMap(params), 0, ""};
  TsdfMap::Storage& storage = loaded.map.storage();
  storage.revision = 1;
  std::size_t intact = 0;
  for (std::size_t at = sizeof header; at + sizeof(GroupHeader) <= content.size();) {
    GroupHeader group{};
    std::memcpy(&group, content.data() + at, sizeof group);
    const bool sound = header_crc(group) == group.crc && group.blocks <= kGroupBlocks &&
                       group.bytes <= content.size() - at - sizeof group;
    if (!sound) {
      ++at;  // look for the next group that makes sense
      continue;
    }
    const auto* data = reinterpret_cast<const std::uint8_t*>(content.data()) + at + sizeof group;
    intact += unpack_group({data, group.bytes}, group.blocks, storage);
    at += sizeof group + group.bytes;
  }
  loaded.lost_blocks = header.blocks - std::min<std::size_t>(header.blocks, intact);
  if (loaded.lost_blocks > 0) {
    loaded.report =
        fmt::format("{}: {} of {} blocks are damaged and left out", path.string(), loaded.lost_blocks, header.blocks);
  }
  return loaded;
}

}  // namespace arpent::mapping
