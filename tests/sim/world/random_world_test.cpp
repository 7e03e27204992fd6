// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/random_world.h"

#include <gtest/gtest.h>

#include "sim/world/ground.h"

namespace arpent::sim {
namespace {

TEST(RandomWorld, FiftySeedsGiveFiftySoundWorlds) {
  for (std::uint32_t seed = 0; seed < 50; ++seed) {
    const World drawn = make_random_world(seed);
    // Reading checks the whole world.
    const World world = parse_world(to_yaml(drawn), "seed " + std::to_string(seed));
    EXPECT_GE(world.starts.size(), 2U);
    World without = world;
    without.tag_cube.reset();
    const GroundMap ground(without);
    for (const Pose2& start : world.starts) {
      EXPECT_GE(ground.distance_m(start.position_m()), 0.8) << seed;
      const Eigen::Vector2d to_cube = world.tag_cube->centre_m.head<2>() - start.position_m();
      EXPECT_LT(std::abs(wrap_angle(std::atan2(to_cube.y(), to_cube.x()) - start.yaw_rad)), 0.02) << seed;
      EXPECT_LT(to_cube.norm(), 2.02) << seed;
    }
  }
}

TEST(RandomWorld, TheSeedDecides) {
  EXPECT_EQ(to_yaml(make_random_world(4)), to_yaml(make_random_world(4)));
  EXPECT_NE(to_yaml(make_random_world(4)), to_yaml(make_random_world(5)));
}

}  // namespace
}  // namespace arpent::sim
