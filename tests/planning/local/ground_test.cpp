// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/ground.h"

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

TEST(Footprint, DiscsCoverTheEllipseAndLittleMore) {
  for (const auto& [a, b] : {std::pair(0.55, 0.25), std::pair(0.3, 0.3), std::pair(1.0, 0.2)}) {
    const Footprint footprint({a, b});
    const Pose2 origin;
    for (int i = 0; i < 2000; ++i) {
      const double t = 2 * std::numbers::pi * i / 2000;
      const Eigen::Vector2d rim(a * std::cos(t), b * std::sin(t));
      const bool covered = std::any_of(footprint.discs().begin(), footprint.discs().end(), [&](const auto& disc) {
        return (rim - Eigen::Vector2d(disc.along_m, 0)).norm() <= disc.radius_m;
      });
      EXPECT_TRUE(covered) << "at " << rim.transpose();
      for (const FootprintDisc& disc : footprint.discs()) {
        const Eigen::Vector2d p(disc.along_m + disc.radius_m * std::cos(t), disc.radius_m * std::sin(t));
        EXPECT_TRUE(footprint.contains(origin, p, 0.1 * b)) << "stands out at " << p.transpose();
      }
    }
  }
  EXPECT_THROW(Footprint({0.2, 0.3}), InputError);
}

TEST(Ground, ClearanceIsTheDistanceToWithinItsPromise) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 5; ++trial) {
    const FlatWorld world = random_world(random, 6);
    const Ground ground = make_ground(world);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d p(uniform(random, 0.2, 7.8), uniform(random, 0.2, 6.8));
      const double d = world.distance_m(p);
      if (d < 0.1) continue;
      EXPECT_LE(ground.clearance_m(p), d + 0.011);
      EXPECT_GE(ground.clearance_m(p), d - 0.08);
    }
  }
  EXPECT_EQ(make_ground({}).clearance_m({-50, 3}), 0);
}

TEST(Ground, APoseIsFreeIfNothingReachesIntoTheEllipse) {
  std::mt19937 random(2);
  const FootprintParams footprint;
  int free = 0, tight = 0;
  for (int trial = 0; trial < 5; ++trial) {
    const FlatWorld world = random_world(random, 6);
    const Ground ground = make_ground(world, footprint);
    for (int i = 0; i < 1000; ++i) {
      const Pose2 pose{uniform(random, 0, 8), uniform(random, 0, 7), uniform(random, -3, 3)};
      const double intrusion = intrusion_m(world, footprint, pose);
      if (ground.is_free(pose)) {
        EXPECT_LE(intrusion, 0.012) << "free, but something is in the ellipse";
        ++free;
      } else if (intrusion < 0) {
        EXPECT_GT(intrusion, -0.12) << "said to be blocked with much room around";
        ++tight;
      }
    }
  }
  EXPECT_GT(free, 500);
  EXPECT_GT(tight, 10);
}

TEST(Ground, MotionsFindTheFirstContactWithThinThings) {
  FlatWorld world;
  world.boxes.push_back({{5, 3.5}, {0.03, 0.03}});
  const Ground ground = make_ground(world);
  const Motion along = drive({1, 3.5, 0}, 6, 0);
  const auto contact = ground.first_contact(along);
  ASSERT_TRUE(contact);
  EXPECT_NEAR(*contact * 6, 5 - 0.03 - 0.55 - 1, 0.08);
  EXPECT_FALSE(ground.first_contact(drive({1, 3.5 + 0.4, 0}, 6, 0)));
  EXPECT_TRUE(ground.first_contact(drive({1, 3.5 + 0.25, 0}, 6, 0)));
  EXPECT_TRUE(ground.first_contact(drive({1, 3.5 + 0.36, 0}, 4, 0)) == std::nullopt) << "its nose passes beside";
  const Pose2 beside{4.55, 3.5, 1.57};
  EXPECT_TRUE(ground.is_free(beside));
  EXPECT_TRUE(ground.first_contact(turn_to(beside, -0.1))) << "the nose would hit the pole";
  EXPECT_FALSE(ground.first_contact(turn_to(beside, 2.2)));
  EXPECT_TRUE(ground.first_contact(turn_to(beside, -1.57))) << "half a circle must be free both ways round";
}

TEST(Ground, WhatIsNearObstaclesCostsMore) {
  const Ground ground = make_ground({});
  EXPECT_NEAR(ground.cost_of(drive({2, 3.5, 0}, 4, 0)), 4, 1e-9);
  const double at_wall = ground.cost_of(drive({2, 0.3, 0}, 4, 0));
  // (1 - 0.3 / 0.7)^2 * 2 more per metre, with the clearance up to 5 cm too small.
  EXPECT_NEAR(at_wall, 4 * (1 + 2 * std::pow(1 - 0.275 / 0.7, 2)), 4 * 0.12);
  EXPECT_NEAR(ground.cost_of(turn_to({4, 3.5, 0}, 1)), ground.costs().stop_m + ground.costs().turn_m_per_rad, 1e-9);
}

}  // namespace
}  // namespace arpent::planning
