// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Queries against analytic surfaces and brute force.
#include "mapping/tsdf/query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

const Eigen::Vector3d kCentre(0.13, -0.07, 0.21);
constexpr double kRadius = 1.0;

/// Free space inside of a ball, known up to `behind` outside of it: distances as they are, without an image.
TsdfMap make_ball(double behind_m = 0.25) {
  TsdfParams params;
  params.voxel_m = 0.1;
  TsdfMap map(params);
  for (int z = -3; z < 3; ++z) {
    for (int y = -3; y < 3; ++y) {
      for (int x = -3; x < 3; ++x) {
        auto block = std::make_unique<Block>();
        block->index = {x, y, z};
        for (int i = 0; i < kBlockVoxels; ++i) {
          const auto at = static_cast<std::size_t>(i);
          const VoxelIndex v = block->index * kBlockSide + VoxelIndex(i & 7, i >> 3 & 7, i >> 6);
          const double d = kRadius - (map.centre_m(v) - kCentre).norm();
          if (d < -behind_m) continue;
          block->distance_m[at] = static_cast<float>(std::min(d, 0.3));
          block->weight[at] = 1;
        }
        map.storage().adopt(std::move(block));
      }
    }
  }
  return map;
}

Eigen::Vector3d random_direction(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(TsdfQuery, InterpolatedDistancesAreThoseOfTheBall) {
  const TsdfMap map = make_ball();
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    const double r = 0.85 + 0.2 * static_cast<double>(i) / 500;
    const auto d = interpolate_distance_m(map, kCentre + r * random_direction(random));
    ASSERT_TRUE(d);
    EXPECT_NEAR(*d, kRadius - r, 0.004);
  }
  EXPECT_FALSE(interpolate_distance_m(map, kCentre + Eigen::Vector3d(1.6, 0, 0))) << "never seen";
  EXPECT_NEAR(*interpolate_distance_m(map, kCentre), 0.3, 1e-6) << "truncated";
}

TEST(TsdfQuery, RaysMeetTheSurfaceFromAnywhereInside) {
  const TsdfMap map = make_ball();
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d o = 0.8 * std::uniform_real_distribution<>(0, 1)(random) * random_direction(random);
    const Eigen::Vector3d d = random_direction(random);
    const RayHit hit = cast_ray(map, kCentre + o, d, 5.0, 0.5);
    ASSERT_EQ(hit.end, RayEnd::kSurface);
    const double b = o.dot(d);
    const double expected = -b + std::sqrt(b * b - o.squaredNorm() + kRadius * kRadius);
    // A ray that leaves at a grazing angle stays near the surface for long: compare across the surface.
    EXPECT_LT(std::abs((o + hit.range_m * d).norm() - kRadius), 0.03);
    const bool steep = (o + expected * d).dot(d) > 0.5;
    EXPECT_NEAR(hit.range_m, expected, steep ? 0.03 : 0.15);
  }
}

TEST(TsdfQuery, EveryVoxelOfARayIsWalkedThrough) {
  const TsdfMap map = make_ball();
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d o = kCentre + 0.5 * random_direction(random), d = random_direction(random);
    const RayHit hit = cast_ray(map, o, d, 5.0, 0.5);
    // Brute force: the first sample that is not empty lies in the voxel where the walk ended, or the walk saw a voxel
    // that the samples stepped over.
    for (double t = 0; t < 5; t += 1e-4) {
      const auto voxel = map.voxel(map.index_of(o + t * d));
      if (voxel && voxel->distance_m > 0) continue;
      EXPECT_GE(t + 1e-3, (map.centre_m(hit.voxel) - o).norm() - 0.09);
      EXPECT_LE((map.centre_m(hit.voxel) - (o + t * d)).norm(), 0.09 + 0.1);
      break;
    }
  }
}

TEST(TsdfQuery, RaysEndAtTheUnknownAndAtTheirRange) {
  const TsdfMap map = make_ball(-0.15);  // the last 15 cm before the surface were not seen
  const RayHit unknown = cast_ray(map, kCentre, Eigen::Vector3d::UnitX(), 5.0, 0.5);
  EXPECT_EQ(unknown.end, RayEnd::kUnknown);
  EXPECT_NEAR(unknown.range_m, 0.85, 0.1);
  const RayHit free = cast_ray(map, kCentre, Eigen::Vector3d::UnitX(), 0.4, 0.5);
  EXPECT_EQ(free.end, RayEnd::kFree);
  EXPECT_DOUBLE_EQ(free.range_m, 0.4);
  EXPECT_EQ(cast_ray(map, kCentre, Eigen::Vector3d::UnitX(), 5.0, 2.0).end, RayEnd::kUnknown) << "weights are 1";
  EXPECT_EQ(cast_ray(map, kCentre, Eigen::Vector3d::UnitX(), 5.0, 2.0).range_m, 0);
}

TEST(TsdfQuery, TheNearestSurfaceIsFoundBeyondTheTruncationDistanceToo) {
  const TsdfMap map = make_ball();
  std::mt19937 random(4);
  for (const double r : {0.05, 0.3, 0.6, 0.9, 1.1}) {
    const auto d = nearest_surface_m(map, kCentre + r * random_direction(random), 1.2);
    ASSERT_TRUE(d) << r;
    EXPECT_NEAR(*d, std::abs(kRadius - r), 0.02) << r;
  }
  EXPECT_FALSE(nearest_surface_m(map, kCentre, 0.8));
}

}  // namespace
}  // namespace arpent::mapping
