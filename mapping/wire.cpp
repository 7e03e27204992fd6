// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/wire.h"

#include <algorithm>
#include <cmath>

#include "common/crc32c.h"

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

namespace {

constexpr double kMaxM = 1e5;
constexpr std::size_t kMaxNameLength = 64;

std::uint32_t checksum(const std::vector<std::uint8_t>& blocks) {
  return crc32c_of(std::span<const std::uint8_t>(blocks));
}

bool is_size(double value) {
  return std::isfinite(value) && value > 0 && value < kMaxM;
}
/// Not a number is in none of the bounds.
bool is_place(const Pose2& pose) {
  return std::abs(pose.x_m) < kMaxM && std::abs(pose.y_m) < kMaxM && std::abs(pose.yaw_rad) < kMaxM;
}
bool is_deviation(double value) {
  return std::isfinite(value) && value >= 0 && value < kMaxM;
}

}  // namespace

map_patch_t to_wire(const MapPatch& patch) {
  map_patch_t message{};
  message.utime = to_utime(patch.newest);
  message.sample = patch.sequence;
  message.source = patch.source;
  message.frame = patch.frame;
  message.voxel_m = patch.voxel_m;
  message.truncation_m = patch.truncation_m;
  message.position_sigma_m = patch.position_sigma_m;
  message.heading_sigma_rad = patch.heading_sigma_rad;
  message.body_count = static_cast<std::int32_t>(patch.bodies.size());
  for (const Pose2& body : patch.bodies) {
    message.body_x_m.push_back(body.x_m);
    message.body_y_m.push_back(body.y_m);
    message.body_yaw_rad.push_back(body.yaw_rad);
  }
  message.size = static_cast<std::int32_t>(patch.blocks.size());
  message.blocks = patch.blocks;
  message.blocks_crc32c = static_cast<std::int32_t>(checksum(patch.blocks));
  return message;
}

Result<MapPatch> from_wire(const map_patch_t& message) {
  if (message.source.empty() || message.source.size() > kMaxNameLength) return Fault{"a patch of nobody"};
  if (message.sample < 0) return Fault{"a sample's number is negative"};
  if (static_cast<std::uint32_t>(message.blocks_crc32c) != checksum(message.blocks)) return Fault{"wrong checksum"};
  if (!is_size(message.voxel_m) || !is_size(message.truncation_m)) return Fault{"a lattice that cannot be"};
  if (!is_deviation(message.position_sigma_m) || !is_deviation(message.heading_sigma_rad)) {
    return Fault{"a deviation that cannot be"};
  }
  MapPatch patch;
  for (std::size_t i = 0; i < message.body_x_m.size(); ++i) {
    const Pose2 body{message.body_x_m[i], message.body_y_m[i], message.body_yaw_rad[i]};
    if (!is_place(body)) return Fault{"a pose that cannot be"};
    patch.bodies.push_back(body);
  }
  patch.source = message.source;
  patch.sequence = message.sample;
  patch.frame = message.frame;
  patch.newest = from_utime(message.utime);
  patch.voxel_m = message.voxel_m;
  patch.truncation_m = message.truncation_m;
  patch.position_sigma_m = message.position_sigma_m;
  patch.heading_sigma_rad = message.heading_sigma_rad;
  patch.blocks = message.blocks;
  return patch;
}

Result<TeammateState> from_wire(const robot_state_t& message) {
  if (message.robot.empty() || message.robot.size() > kMaxNameLength) return Fault{"the state of nobody"};
  const Twist2 twist{message.speed_mps, message.turn_rate_radps};
  const Pose2 body{message.x_m, message.y_m, message.yaw_rad};
  if (!is_place(body)) return Fault{"a pose that cannot be"};
  if (!(std::abs(twist.speed_mps) < 100 && std::abs(twist.turn_rate_radps) < 100)) return Fault{"a twist too fast"};
  return TeammateState{message.robot, from_utime(message.utime), body, twist};
}

}  // namespace arpent::mapping
