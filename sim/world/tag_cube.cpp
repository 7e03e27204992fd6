// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/tag_cube.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <cstdlib>
#include <numbers>
#include <string>

#include "common/error.h"

namespace arpent::sim {
namespace {

struct Family {
  apriltag_family_t* family = tag36h11_create();
  Family() = default;
  Family(const Family&) = delete;
  Family& operator=(const Family&) = delete;
  ~Family() { tag36h11_destroy(family); }
};

}  // namespace

std::array<PlacedTag, 4> placed_tags(const TagCube& cube) {
  std::array<PlacedTag, 4> tags;
  for (std::size_t k = 0; k < 4; ++k) {
    PlacedTag& tag = tags[k];
    const double yaw = cube.yaw_rad + static_cast<double>(k) * std::numbers::pi / 2;
    const Eigen::Vector3d outwards(std::cos(yaw), std::sin(yaw), 0);
    const Eigen::Vector3d right(-outwards.y(), outwards.x(), 0);  // of somebody who looks at the face
    const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
    tag.id = cube.ids[k];
    tag.T_world_tag.translation() = cube.centre_m + 0.5 * cube.edge_m * outwards;
    tag.T_world_tag.linear() << right, -up, -outwards;
    const double half = 0.5 * cube.tag_m;
    const Eigen::Vector3d centre = tag.T_world_tag.translation();
    tag.corners_m = {centre + half * (-right - up), centre + half * (right - up), centre + half * (right + up),
                     centre + half * (-right + up)};
  }
  return tags;
}

std::array<std::uint8_t, 100> tag_cells(int id) {
  const Family tags;
  if (id < 0 || id >= static_cast<int>(tags.family->ncodes)) {
    throw InputError("the tag family 36h11 has no tag " + std::to_string(id));
  }
  image_u8_t* image = apriltag_to_image(tags.family, static_cast<std::uint32_t>(id));
  ARPENT_ASSERT(image->width == 10 && image->height == 10);
  std::array<std::uint8_t, 100> cells{};
  for (int row = 0; row < 10; ++row) {
    for (int col = 0; col < 10; ++col) {
      cells[static_cast<std::size_t>(10 * row + col)] = image->buf[row * image->stride + col];
    }
  }
  // What image_u8_destroy does, which Debian's library does not export.
  std::free(image->buf);
  std::free(image);
  return cells;
}

int tag_count() {
  return static_cast<int>(Family().family->ncodes);
}

}  // namespace arpent::sim
