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
  int threads = 1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("voxel_m", self.voxel_m, "edge of a voxel (r_v)", config::between(0.005, 10.0));
    visitor.field("known_weight", self.known_weight, "weight from which a voxel is known (W_th)",
                  config::greater_than(0.0));
    visitor.field("min_range_m", self.min_range_m, "nearest depth used", config::greater_than(0.0));
    visitor.field("max_range_m", self.max_range_m, "farthest depth used", config::between(0.1, 1000.0));
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

  /// Fuses one depth image seen from `T_map_cam`. The same sequence of calls gives the same map, with any number of
  /// threads.
  void integrate(const stereo::DepthMap& depth, const Pose& T_map_cam);

  [[nodiscard]] const TsdfParams& params() const;
  /// nullopt where nothing was ever seen.
  [[nodiscard]] std::optional<Voxel> voxel(const VoxelIndex& index) const;
  [[nodiscard]] std::size_t block_count() const;
  /// CRC-32C over the map's content in a canonical order: equal maps, equal digests.
  [[nodiscard]] std::uint32_t digest() const;

  struct Storage;
  [[nodiscard]] Storage& storage();
  [[nodiscard]] const Storage& storage() const;

 private:
  std::unique_ptr<Storage> storage_;
};

}  // namespace arpent::mapping
