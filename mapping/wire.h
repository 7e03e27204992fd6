// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of mapping: map_status_t, map_patch_t; of robot_state_t what the mask needs.
#pragma once

#include <arpent/map_patch_t.hpp>
#include <arpent/map_status_t.hpp>
#include <arpent/robot_state_t.hpp>
#include <cstdint>

#include "common/result.h"
#include "common/time.h"
#include "mapping/exchange/map_patch.h"
#include "mapping/exchange/teammate_poses.h"

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

[[nodiscard]] map_patch_t to_wire(const MapPatch& patch);
/// Checks the checksum, numbers and names. The blocks are looked at when they are fused.
[[nodiscard]] Result<MapPatch> from_wire(const map_patch_t& message);

/// Where the teammate says that it is.
[[nodiscard]] Result<TeammateState> from_wire(const robot_state_t& message);

}  // namespace arpent::mapping
