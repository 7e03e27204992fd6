// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of mapping: map_status_t.
#pragma once

#include <arpent/map_status_t.hpp>
#include <cstdint>

#include "common/result.h"
#include "common/time.h"

namespace arpent::mapping {

/// The state of a map after one fusion.
struct MapStatus {
  Time stamp;
  std::int64_t depth_sequence = 0;
  Time odometry_stamp;
  std::int64_t integrated = 0;
  std::int64_t rejected = 0;
  std::int64_t block_count = 0;
  std::int64_t known_voxel_count = 0;
  double voxel_m = 0;
  std::uint32_t digest = 0;
};

[[nodiscard]] map_status_t to_wire(const MapStatus& status);
/// Checks that counts are not negative and the voxel's edge is a positive number.
[[nodiscard]] Result<MapStatus> from_wire(const map_status_t& message);

}  // namespace arpent::mapping
