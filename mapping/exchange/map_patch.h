// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Patches: what a robot's last depth images say about its surroundings, on its way into other maps (thesis Sect. 4.3,
// 4.4.1). A patch is a TSDF of its own, on the lattice of the common frame, so that fusing is exact:
// w = sum_p w_p, phi = (sum_p w_p phi_p) / w. It is sent as samples, each known by source and sequence, complete in
// itself, and fused at most once.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "common/pose2.h"
#include "common/result.h"
#include "common/time.h"
#include "mapping/tsdf/tsdf_map.h"

namespace arpent::mapping {

struct MapPatch {
  std::string source;         ///< the robot that integrated it
  std::int64_t sequence = 0;  ///< counts the source's samples from 0
  std::string frame;
  Time newest;         ///< of the depth images in it
  double voxel_m = 0;  ///< of the lattice
  double truncation_m = 0;
  double position_sigma_m = 0;       ///< of the poses that it was integrated from, the worst
  double heading_sigma_rad = 0;      ///< the same
  std::vector<Pose2> bodies;         ///< where the source's depth images were taken; in a patch's last sample only
  std::vector<std::uint8_t> blocks;  ///< coded (block_code.h)
};

/// Adds the sample to the map. A fault, and nothing changes, if the sample is damaged or was made for another lattice.
/// Weights saturate as those of integrated images do.
[[nodiscard]] Result<std::size_t> fuse(TsdfMap& map, const MapPatch& patch);

/// Which samples were taken already, by source.
class PatchLedger {
 public:
  /// False if it was there before.
  bool add(const std::string& source, std::int64_t sequence);
  /// Every sequence below it came.
  [[nodiscard]] std::int64_t all_below(const std::string& source) const;
  /// Sequences below the newest that did not come (yet).
  [[nodiscard]] std::vector<std::int64_t> missing(const std::string& source) const;

 private:
  struct Source {
    std::int64_t all_below = 0;     ///< every sequence below it came
    std::set<std::int64_t> beyond;  ///< that came already
  };
  std::map<std::string, Source> sources_;
};

}  // namespace arpent::mapping
