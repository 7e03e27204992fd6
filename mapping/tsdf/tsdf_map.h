// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The map: a truncated signed distance field in hashed blocks (thesis Sect. 1.3.3, 2.4.1). Depth images are fused with
// weight 1/z^2; a voxel is known once its weight reaches `known_weight` (W_th), which planning asks about and meshing
// does not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>

#include "common/config/fields.h"
#include "common/geometry.h"
#include "perception/stereo/depth_map.h"

namespace arpent::mapping {

struct TsdfParams {
  double voxel_m = 0.1;
  double known_weight = 0.3;
  double min_range_m = 0.3;
  double max_range_m = 5.0;
  double truncation_voxels = 3.0;
  double max_weight = 100.0;
  int max_blocks = 400000;
  int threads = 1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("voxel_m", self.voxel_m, "edge of a voxel (r_v)", config::between(0.005, 10.0));
    visitor.field("known_weight", self.known_weight, "weight from which a voxel is known (W_th)",
                  config::greater_than(0.0));
    visitor.field("min_range_m", self.min_range_m, "nearest depth used", config::greater_than(0.0));
    visitor.field("max_range_m", self.max_range_m, "farthest depth used", config::between(0.1, 1000.0));
    visitor.field("truncation_voxels", self.truncation_voxels, "truncation distance in voxels, across the surface",
                  config::between(1.0, 20.0));
    visitor.field("max_weight", self.max_weight, "weight at which a voxel saturates", config::greater_than(0.0));
    visitor.field("max_blocks", self.max_blocks, "blocks of 8 x 8 x 8 voxels (4 kB each) that the map may hold",
                  config::at_least(1));
    visitor.field("threads", self.threads, "threads of one integration; the map does not depend on it",
                  config::between(1, 16));
  }
};

/// What `voxel` of a map says. `distance_m` > 0 in empty space; meaningful only if `weight` > 0.
struct Voxel {
  float distance_m = 0;
  float weight = 0;
};

using VoxelIndex =
    Eigen::Vector3i;  ///< voxel (i, j, k) has its centre at (i + 0.5, j + 0.5, k + 0.5) * voxel_m in the map frame

class TsdfMap {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit TsdfMap(const TsdfParams& params);
  ~TsdfMap();
  TsdfMap(TsdfMap&&) noexcept;
  TsdfMap& operator=(TsdfMap&&) noexcept;

  /// Fuses one depth image seen from `T_map_cam`. Pixels that are not finite or too near count as missing; those
  /// farther than the range tell that nothing is in the way up to there (in a large hall nothing else does). False, and
  /// nothing changes, if the pose is not finite or too far away to index. The same sequence of calls gives the same
  /// map, with any number of threads.
  bool integrate(const stereo::DepthMap& depth, const Pose& T_map_cam);

  [[nodiscard]] const TsdfParams& params() const;
  /// nullopt where nothing was ever seen.
  [[nodiscard]] std::optional<Voxel> voxel(const VoxelIndex& index) const;
  [[nodiscard]] bool is_known(const VoxelIndex& index) const;
  [[nodiscard]] VoxelIndex index_of(const Eigen::Vector3d& p_map_m) const;
  [[nodiscard]] Eigen::Vector3d centre_m(const VoxelIndex& index) const;

  [[nodiscard]] std::size_t block_count() const;
  [[nodiscard]] std::size_t known_voxel_count() const;
  /// Blocks that could not be created because the map is full (max_blocks).
  [[nodiscard]] std::int64_t refused_blocks() const;
  /// Number of integrations so far; blocks carry the revision that touched them last.
  [[nodiscard]] std::int64_t revision() const;
  /// Checksum of the map's content, whatever the order in which its blocks came to be: equal maps, equal digests. Costs
  /// as much as changed since it was last asked.
  [[nodiscard]] std::uint32_t digest();

  struct Storage;
  [[nodiscard]] Storage& storage();
  [[nodiscard]] const Storage& storage() const;

 private:
  std::unique_ptr<Storage> storage_;
};

}  // namespace arpent::mapping
