// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The calibration cube that defines the world frame: one AprilTag of the family 36h11 on each side face, on a thin
// stand. Plain numbers: where each tag's corners are.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "common/geometry.h"

namespace arpent::sim {

/// The faces look towards yaw_rad + k * 90 degrees, k = 0..3, and carry the tags `ids[k]`, upright.
struct TagCube {
  Eigen::Vector3d centre_m = {0, 0, 0.40};
  double yaw_rad = 0;
  double edge_m = 0.30;
  double tag_m = 0.24;  ///< outer edge of the black border
  std::array<int, 4> ids{0, 1, 2, 3};
  double stand_m = 0.04;  ///< width of the square stand below the cube
};

/// One tag in the world. Corners as the AprilTag library orders them: seen from the front bottom left, bottom right,
/// top right, top left. `T_world_tag`: origin in the tag's centre, x right, y down, z into the cube.
struct PlacedTag {
  int id = 0;
  std::array<Eigen::Vector3d, 4> corners_m;
  Pose T_world_tag = Pose::Identity();
};

[[nodiscard]] std::array<PlacedTag, 4> placed_tags(const TagCube& cube);

/// A tag of the family 36h11 with its white margin: 10 x 10 cells, row by row from the top, 0 black, 255 white. Throws
/// InputError if the family has no such tag.
[[nodiscard]] std::array<std::uint8_t, 100> tag_cells(int id);
/// Number of tags in the family.
[[nodiscard]] int tag_count();

}  // namespace arpent::sim
