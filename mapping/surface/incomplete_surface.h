// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where the map's surface is incomplete: incomplete surface elements (ISEs, thesis Def. 1), the voxels at which the
// surface borders on both free and unknown space, and the direction from which each wants to be seen. Only blocks that
// changed, and those beside them, are judged again.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "mapping/surface/voxel_classes.h"

namespace arpent::mapping {

struct IncompleteElement {
  VoxelIndex voxel = VoxelIndex::Zero();  ///< its name, the same from one extraction to the next
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  /// Unit vector nbar_v away from the occupied side (thesis Sect. 2.4.2): from there it wants to be seen.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
  /// Unit normal of the surface as the distances beside the voxel have it (towards empty space): unlike the direction,
  /// not drawn towards the unknown side. And the voxel's distance from the surface.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance_m = 0;
};

/// The order in which elements are listed: by z, then y, then x.
[[nodiscard]] bool before(const VoxelIndex& a, const VoxelIndex& b);

/// Which unknown voxels make an element of the empty voxel beside them.
enum class UnknownRule : std::uint8_t {
  kWeight,  ///< all: weight < W_th, as Def. 1 says
  /// Not those that were seen, too seldom, behind the very surface that the empty voxel lies on: their distance is of
  /// the other sign and one that a distance field allows one voxel further. There the surface has been found, W_th is
  /// met on its visible side, and how often the map's limits behind rims let the hidden side be updated is no
  /// incompleteness (docs/decisions/0005). Nor is there an element where no surface is: where the map is torn.
  kSignChange,
};

class IncompleteSurface {
 public:
  /// With a region, only voxels whose centre lies in it (map frame) can be elements, and with kSignChange what is
  /// unknown beyond it makes none.
  explicit IncompleteSurface(UnknownRule rule = UnknownRule::kSignChange,
                             std::optional<Eigen::AlignedBox3d> region_map_m = std::nullopt);
  ~IncompleteSurface();
  IncompleteSurface(IncompleteSurface&&) noexcept;
  IncompleteSurface& operator=(IncompleteSurface&&) noexcept;

  /// Takes over what changed in the map (always the same one) since the last call. Returns how many blocks were judged.
  std::size_t update(const TsdfMap& map);

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool contains(const VoxelIndex& voxel) const;
  /// The voxels of all elements, ordered by before().
  [[nodiscard]] std::vector<VoxelIndex> voxels() const;
  /// All elements, in the same order. `map` is the one of the last update.
  [[nodiscard]] std::vector<IncompleteElement> elements(const TsdfMap& map) const;
  /// The unknown voxels among the six beside `voxel` that make it an element. `map` is the one of the last update.
  [[nodiscard]] std::vector<VoxelIndex> unknown_beside(const VoxelIndex& voxel, const TsdfMap& map) const;
  [[nodiscard]] const VoxelClasses& classes() const { return classes_; }

 private:
  /// Whether an occupied voxel among the 18 beside it is as near in distance as it is in space. A greater leap is no
  /// surface but a tear: what one view guessed behind an object's rim beside what another saw to be free.
  [[nodiscard]] bool lies_on_surface(const VoxelIndex& voxel, const TsdfMap& map) const;
  [[nodiscard]] BlockBits judge(const BlockClasses& block, const TsdfMap& map) const;

  UnknownRule rule_;
  std::optional<Eigen::AlignedBox3d> region_map_m_;
  VoxelClasses classes_;
  std::vector<BlockBits> elements_;  ///< beside classes_.blocks()
  std::unordered_map<BlockIndex, std::size_t, BlockHash> position_of_;
  std::size_t size_ = 0;
};

}  // namespace arpent::mapping
