// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/world_check.h"

#include <fmt/format.h>

#include "sim/world/ground.h"

namespace arpent::sim {

void check_world(const World& world, const std::vector<int>& start_lines, Faults& faults) {
  const GroundMap ground(world);
  if (world.starts.empty()) faults.add(0, "a world needs a start");
  for (std::size_t i = 0; i < world.starts.size(); ++i) {
    const Pose2& start = world.starts[i];
    const std::string name = fmt::format("start {} at ({}, {})", i, start.x_m, start.y_m);
    const Eigen::Vector2d p = start.position_m();
    if ((p.array() < world.region.min_m.head<2>().array()).any() ||
        (p.array() > world.region.max_m.head<2>().array()).any()) {
      faults.add(start_lines[i], name + " is outside the region");
    }
    if (ground.hits(start, {})) faults.add(start_lines[i], name + " touches an obstacle");
    for (std::size_t k = 0; k < i; ++k) {
      if (overlap(world.starts[k], {}, start, {})) {
        faults.add(start_lines[i], fmt::format("{} touches start {} (line {})", name, k, start_lines[k]));
      }
    }
  }
  if (!world.tag_cube) return;
  World without = world;
  without.tag_cube.reset();
  const TagCube& cube = *world.tag_cube;
  if (GroundMap(without, 0.02, cube.centre_m.z() + cube.edge_m).distance_m(cube.centre_m.head<2>()) <
      0.71 * cube.edge_m) {
    faults.add(0, "the tag cube touches an obstacle");
  }
  if (!world.region.contains(cube.centre_m)) faults.add(0, "the tag cube is outside the region");
}

}  // namespace arpent::sim
