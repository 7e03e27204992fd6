// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/surface/incomplete_surface.h"

#include <algorithm>
#include <bit>
#include <numbers>
#include <tuple>

namespace arpent::mapping {
namespace {

constexpr int kPadded = kBlockSide + 2;
/// A distance field changes by at most a voxel from one voxel to the next; half a voxel more for noise.
constexpr float kSteepestField = 1.5F;

/// The bits of a block and of the voxels around it: row (y, z), counted from -1, has voxel x at bit x + 1. Voxels of
/// blocks that the map does not have are `absent`.
class PaddedRows {
 public:
  template <class Bits>
  PaddedRows(const BlockClasses& block, bool absent, const Bits& bits) {
    for (int z = -1; z <= kBlockSide; ++z) {
      for (int y = -1; y <= kBlockSide; ++y) {
        const int side = 3 * (side_of(y) + 3 * side_of(z));
        const auto row = [&](int dx) -> std::uint32_t {
          const BlockClasses* at = block.around[static_cast<std::size_t>(side + dx)];
          if (at == nullptr) return absent ? 0xFF : 0;
          return static_cast<std::uint32_t>(bits(*at, static_cast<std::size_t>(z & 7)) >> (8 * (y & 7)) & 0xFF);
        };
        rows_[place(y, z)] = row(0) >> 7 | row(1) << 1 | (row(2) & 1) << 9;
      }
    }
  }
  [[nodiscard]] std::uint32_t operator()(int y, int z) const { return rows_[place(y, z)]; }

 private:
  static int side_of(int i) { return i < 0 ? 0 : i < kBlockSide ? 1 : 2; }
  static std::size_t place(int y, int z) { return static_cast<std::size_t>(y + 1 + kPadded * (z + 1)); }
  std::array<std::uint32_t, kPadded * kPadded> rows_;
};

std::uint32_t beside(std::uint32_t row) {
  return row << 1 | row >> 1;
}

/// Which voxels of the row have one of `rows` among their six neighbours.
std::uint32_t near6(const PaddedRows& rows, int y, int z) {
  return beside(rows(y, z)) | rows(y - 1, z) | rows(y + 1, z) | rows(y, z - 1) | rows(y, z + 1);
}

/// The same for the 18 neighbours that share a face or an edge.
std::uint32_t near18(const PaddedRows& rows, int y, int z) {
  const std::uint32_t faces = rows(y - 1, z) | rows(y + 1, z) | rows(y, z - 1) | rows(y, z + 1);
  const std::uint32_t edges =
      rows(y - 1, z - 1) | rows(y - 1, z + 1) | rows(y + 1, z - 1) | rows(y + 1, z + 1) | beside(faces);
  return beside(rows(y, z)) | faces | edges;
}

bool any(const BlockBits& bits) {
  return std::any_of(bits.begin(), bits.end(), [](std::uint64_t word) { return word != 0; });
}

template <class Work>
void for_each_bit(const BlockBits& bits, const Work& work) {
  for (std::size_t z = 0; z < bits.size(); ++z) {
    for (std::uint64_t word = bits[z]; word != 0; word &= word - 1) {
      work(64 * z + static_cast<std::size_t>(std::countr_zero(word)));
    }
  }
}

VoxelIndex voxel_at(const BlockIndex& block, std::size_t offset) {
  const auto i = static_cast<int>(offset);
  return kBlockSide * block + VoxelIndex(i & 7, i >> 3 & 7, i >> 6);
}

std::size_t count(const BlockBits& bits) {
  std::size_t sum = 0;
  for (const std::uint64_t word : bits) sum += static_cast<std::size_t>(std::popcount(word));
  return sum;
}

/// Thesis Def. 1: empty, an unknown voxel among the 6 neighbours, an occupied one among the 18.
BlockBits find_candidates(const BlockClasses& block) {
  BlockBits found{};
  if (!any(block.empty)) return found;
  const bool surface =
      std::any_of(block.around.begin(), block.around.end(), [](const auto* b) { return b && any(b->occupied); });
  if (!surface) return found;
  const PaddedRows occupied(block, false, [](const BlockClasses& b, std::size_t z) { return b.occupied[z]; });
  const PaddedRows unknown(block, true,
                           [](const BlockClasses& b, std::size_t z) { return ~(b.empty[z] | b.occupied[z]); });
  for (int z = 0; z < kBlockSide; ++z) {
    std::uint64_t word = 0;
    for (int y = 0; y < kBlockSide; ++y) {
      const std::uint32_t row = near6(unknown, y, z) & near18(occupied, y, z);
      word |= static_cast<std::uint64_t>(row >> 1 & 0xFF) << (8 * y);
    }
    found[static_cast<std::size_t>(z)] = word & block.empty[static_cast<std::size_t>(z)];
  }
  return found;
}

/// n_v = sum over the 26 neighbours of w'(c) (c - v) / |c - v|, w' = -W_th for occupied ones and W_th for others
/// (thesis Sect. 2.4.2). The unit vectors to all 26 cancel, so the occupied ones decide alone. The factor is left out.
Eigen::Vector3d away_from_occupied(const VoxelClasses& classes, const VoxelIndex& voxel) {
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  for (int i = 0; i < 27; ++i) {
    const VoxelIndex step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    if (i == 13 || classes.at(voxel + step) != VoxelClass::kOccupied) continue;
    n -= step.cast<double>().normalized();
  }
  return n;
}

/// Gradient of the distance, by differences to the neighbours that were seen.
Eigen::Vector3d distance_gradient(const TsdfMap& map, const VoxelIndex& voxel) {
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  const float here = map.voxel(voxel).value_or(Voxel{}).distance_m;
  for (int k = 0; k < 3; ++k) {
    const auto after = map.voxel(voxel + VoxelIndex::Unit(k)), prior = map.voxel(voxel - VoxelIndex::Unit(k));
    gradient[k] = static_cast<double>((after ? after->distance_m : here) - (prior ? prior->distance_m : here));
  }
  return gradient;
}

IncompleteElement describe(const VoxelClasses& classes, const TsdfMap& map, const VoxelIndex& voxel) {
  constexpr double kTiny = 1e-6;
  const Eigen::Vector3d away = away_from_occupied(classes, voxel), gradient = distance_gradient(map, voxel);
  IncompleteElement element{.voxel = voxel, .centre_m = map.centre_m(voxel)};
  element.distance_m = static_cast<double>(map.voxel(voxel).value_or(Voxel{}).distance_m);
  if (gradient.norm() > kTiny) {
    element.normal = gradient.normalized();
  } else if (away.norm() > kTiny) {
    element.normal = away.normalized();
  }
  // Zero between two surfaces: away from the nearer one.
  element.direction = away.norm() > kTiny ? away.normalized() : element.normal;
  return element;
}

}  // namespace

bool before(const VoxelIndex& a, const VoxelIndex& b) {
  return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

IncompleteSurface::IncompleteSurface(UnknownRule rule, std::optional<Eigen::AlignedBox3d> region_map_m)
    : rule_(rule), region_map_m_(std::move(region_map_m)) {}
IncompleteSurface::~IncompleteSurface() = default;
IncompleteSurface::IncompleteSurface(IncompleteSurface&&) noexcept = default;
IncompleteSurface& IncompleteSurface::operator=(IncompleteSurface&&) noexcept = default;

BlockBits IncompleteSurface::judge(const BlockClasses& block, const TsdfMap& map) const {
  BlockBits found = find_candidates(block);
  if (rule_ == UnknownRule::kWeight && !region_map_m_) return found;
  for_each_bit(found, [&](std::size_t offset) {
    const VoxelIndex voxel = voxel_at(block.index, offset);
    const bool inside = !region_map_m_ || region_map_m_->contains(map.centre_m(voxel));
    const bool literal = rule_ == UnknownRule::kWeight;
    if (inside && (literal || (lies_on_surface(voxel, map) && !unknown_beside(voxel, map).empty()))) return;
    found[offset >> 6] &= ~(std::uint64_t{1} << (offset & 63));
  });
  return found;
}

bool IncompleteSurface::lies_on_surface(const VoxelIndex& voxel, const TsdfMap& map) const {
  const float here_m = map.voxel(voxel).value_or(Voxel{}).distance_m;
  const float step_m = kSteepestField * static_cast<float>(map.params().voxel_m);
  for (int i = 0; i < 27; ++i) {
    const VoxelIndex step(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1);
    const int faces = step.squaredNorm();
    if (faces == 0 || faces > 2 || classes_.at(voxel + step) != VoxelClass::kOccupied) continue;
    const float leap_m = here_m - map.voxel(voxel + step).value_or(Voxel{}).distance_m;
    if (leap_m <= step_m * (faces == 1 ? 1.0F : std::numbers::sqrt2_v<float>)) return true;
  }
  return false;
}

std::vector<VoxelIndex> IncompleteSurface::unknown_beside(const VoxelIndex& voxel, const TsdfMap& map) const {
  std::vector<VoxelIndex> unknown;
  const float here_m = map.voxel(voxel).value_or(Voxel{}).distance_m;
  const float step_m = kSteepestField * static_cast<float>(map.params().voxel_m);
  for (int i = 0; i < 6; ++i) {
    const VoxelIndex neighbour = voxel + (i % 2 == 0 ? 1 : -1) * VoxelIndex::Unit(i / 2);
    if (classes_.at(neighbour) != VoxelClass::kUnknown) continue;
    // What lies beyond the region need not be known (the literal rule knows no region's border).
    if (rule_ != UnknownRule::kWeight && region_map_m_ && !region_map_m_->contains(map.centre_m(neighbour))) continue;
    const auto seen = map.voxel(neighbour);
    const bool behind = seen && seen->distance_m <= 0 && here_m - seen->distance_m <= step_m;
    if (rule_ == UnknownRule::kWeight || !behind) unknown.push_back(neighbour);
  }
  return unknown;
}

std::size_t IncompleteSurface::update(const TsdfMap& map) {
  const std::vector<std::size_t> touched = classes_.update(map);
  const auto& blocks = classes_.blocks();
  for (std::size_t i = elements_.size(); i < blocks.size(); ++i) position_of_.emplace(blocks[i]->index, i);
  elements_.resize(blocks.size());
  std::vector<std::uint8_t> stale(blocks.size());
  for (const std::size_t i : touched) {
    for (const BlockClasses* b : blocks[i]->around) {
      if (b != nullptr) stale[position_of_.at(b->index)] = 1;
    }
  }
  std::size_t judged = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (stale[i] == 0) continue;
    ++judged;
    size_ -= count(elements_[i]);
    elements_[i] = judge(*blocks[i], map);
    size_ += count(elements_[i]);
  }
  return judged;
}

bool IncompleteSurface::contains(const VoxelIndex& voxel) const {
  const auto found = position_of_.find(block_of(voxel));
  return found != position_of_.end() && bit_of(elements_[found->second], offset_in_block(voxel));
}

std::vector<VoxelIndex> IncompleteSurface::voxels() const {
  std::vector<VoxelIndex> list;
  list.reserve(size_);
  for (std::size_t i = 0; i < elements_.size(); ++i) {
    for_each_bit(elements_[i],
                 [&](std::size_t offset) { list.push_back(voxel_at(classes_.blocks()[i]->index, offset)); });
  }
  std::sort(list.begin(), list.end(), before);
  return list;
}

std::vector<IncompleteElement> IncompleteSurface::elements(const TsdfMap& map) const {
  std::vector<IncompleteElement> list;
  list.reserve(size_);
  for (const VoxelIndex& voxel : voxels()) list.push_back(describe(classes_, map, voxel));
  return list;
}

}  // namespace arpent::mapping
