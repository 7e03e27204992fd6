// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/wire.h"

#include <cmath>

namespace arpent::mapping {

map_status_t to_wire(const MapStatus& status) {
  map_status_t message{};
  message.utime = to_utime(status.stamp);
  message.depth_sequence = status.depth_sequence;
  message.odometry_utime = to_utime(status.odometry_stamp);
  message.integrated = status.integrated;
  message.rejected = status.rejected;
  message.block_count = status.block_count;
  message.known_voxel_count = status.known_voxel_count;
  message.voxel_m = status.voxel_m;
  message.digest_crc32c = static_cast<std::int32_t>(status.digest);
  return message;
}

Result<MapStatus> from_wire(const map_status_t& message) {
  if (message.integrated < 0 || message.rejected < 0 || message.block_count < 0 || message.known_voxel_count < 0) {
    return Fault{"a count is negative"};
  }
  if (!std::isfinite(message.voxel_m) || message.voxel_m <= 0) return Fault{"voxel_m is not a positive number"};
  MapStatus status;
  status.stamp = from_utime(message.utime);
  status.depth_sequence = message.depth_sequence;
  status.odometry_stamp = from_utime(message.odometry_utime);
  status.integrated = message.integrated;
  status.rejected = message.rejected;
  status.block_count = message.block_count;
  status.known_voxel_count = message.known_voxel_count;
  status.voxel_m = message.voxel_m;
  status.digest = static_cast<std::uint32_t>(message.digest_crc32c);
  return status;
}

}  // namespace arpent::mapping
