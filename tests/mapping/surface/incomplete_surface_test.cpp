// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Incomplete surface elements against Definition 1 read literally, voxel by voxel, and on scenes made by hand.
#include "mapping/surface/incomplete_surface.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

constexpr float kKnown = 1.0F;
constexpr float kTooLittle = 0.1F;  // W_th is 0.3

struct VoxelOrder {
  bool operator()(const VoxelIndex& a, const VoxelIndex& b) const { return before(a, b); }
};
using Voxels = std::set<VoxelIndex, VoxelOrder>;

TsdfMap make_map(double voxel_m = 0.1) {
  TsdfParams params;
  params.voxel_m = voxel_m;
  return TsdfMap(params);
}

void set(TsdfMap& map, const VoxelIndex& voxel, float distance_m, float weight) {
  TsdfMap::Storage& storage = map.storage();
  auto found = storage.by_index.find(block_of(voxel));
  if (found == storage.by_index.end()) {
    auto block = std::make_unique<Block>();
    block->index = block_of(voxel);
    storage.adopt(std::move(block));
    found = storage.by_index.find(block_of(voxel));
  }
  found->second->distance_m[offset_in_block(voxel)] = distance_m;
  found->second->weight[offset_in_block(voxel)] = weight;
  found->second->revision = storage.revision;
}

/// Every voxel of a box, from a function that returns (distance, weight).
template <class Content>
void fill(TsdfMap& map, const VoxelIndex& least, const VoxelIndex& most, const Content& content) {
  for (int z = least.z(); z <= most.z(); ++z) {
    for (int y = least.y(); y <= most.y(); ++y) {
      for (int x = least.x(); x <= most.x(); ++x) {
        const auto [distance_m, weight] = content(VoxelIndex(x, y, z));
        set(map, {x, y, z}, distance_m, weight);
      }
    }
  }
}

bool is_occupied(const TsdfMap& map, const VoxelIndex& v) {
  return map.is_known(v) && map.voxel(v)->distance_m <= 0;
}

/// Thesis Def. 1, over every voxel of the map's blocks.
Voxels by_definition(const TsdfMap& map) {
  Voxels found;
  for (const auto& block : map.storage().blocks) {
    for (int i = 0; i < kBlockVoxels; ++i) {
      const VoxelIndex v = kBlockSide * block->index + VoxelIndex(i & 7, i >> 3 & 7, i >> 6);
      if (!map.is_known(v) || map.voxel(v)->distance_m <= 0) continue;
      bool unknown = false, occupied = false;
      for (int n = 0; n < 27; ++n) {
        const VoxelIndex step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        const int length = step.cwiseAbs().sum();
        unknown = unknown || (length == 1 && !map.is_known(v + step));
        occupied = occupied || ((length == 1 || length == 2) && is_occupied(map, v + step));
      }
      if (unknown && occupied) found.insert(v);
    }
  }
  return found;
}

Voxels voxels_of(const IncompleteSurface& surface, const TsdfMap& map) {
  Voxels found;
  for (const auto& element : surface.elements(map)) found.insert(element.voxel);
  return found;
}

/// Changes some voxels at random, as an integration would: a new revision, some blocks.
void disturb(TsdfMap& map, std::mt19937& random) {
  ++map.storage().revision;
  std::uniform_int_distribution<int> centre(-20, 20), coin(0, 9);
  std::uniform_real_distribution<float> distance(-0.2F, 0.2F), weight(0.0F, 1.0F);
  const VoxelIndex at(centre(random), centre(random), centre(random));
  fill(map, at, at + VoxelIndex(6, 5, 4),
       [&](const VoxelIndex&) { return std::pair(distance(random), coin(random) == 0 ? 0.0F : weight(random)); });
}

TEST(IncompleteSurface, IsDefinitionOneReadLiterally) {
  std::mt19937 random(1);
  TsdfMap map = make_map();
  for (int i = 0; i < 60; ++i) disturb(map, random);
  IncompleteSurface surface(UnknownRule::kWeight);
  surface.update(map);
  const Voxels expected = by_definition(map);
  EXPECT_GT(expected.size(), 500U);
  EXPECT_EQ(voxels_of(surface, map), expected);
  EXPECT_EQ(surface.size(), expected.size());
}

TEST(IncompleteSurface, FollowingTheMapGivesTheSameAsLookingAtAllOfIt) {
  std::mt19937 random(2);
  for (const UnknownRule rule : {UnknownRule::kWeight, UnknownRule::kSignChange}) {
    TsdfMap map = make_map();
    IncompleteSurface followed(rule);
    for (int i = 0; i < 40; ++i) {
      disturb(map, random);
      followed.update(map);
      IncompleteSurface fresh(rule);
      fresh.update(map);
      ASSERT_EQ(voxels_of(followed, map), voxels_of(fresh, map)) << "after change " << i;
      ASSERT_EQ(followed.size(), fresh.size());
    }
    EXPECT_EQ(followed.update(map), 0U) << "nothing changed";
  }
}

TEST(IncompleteSurface, FollowsRealIntegrationsToo) {
  const PinholeCamera camera{96, 80, 60, 60, 47.5, 39.5};
  TsdfMap map = make_map();
  IncompleteSurface followed(UnknownRule::kWeight);
  for (int i = 0; i < 6; ++i) {
    const stereo::DepthMap depth{camera, cv::Mat1f(80, 96, 1.5F + 0.05F * static_cast<float>(i)),
                                 cv::Mat1f(80, 96, 0.01F)};
    ASSERT_TRUE(map.integrate(depth, Pose(Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d::UnitY()))));
    followed.update(map);
    ASSERT_EQ(voxels_of(followed, map), by_definition(map));
  }
  EXPECT_GT(followed.size(), 0U);
}

/// A floor at z = 0 (voxels below are occupied), known for x < 4 only.
TsdfMap make_half_floor() {
  TsdfMap map = make_map();
  fill(map, {-4, -4, -2}, {3, 4, 3},
       [](const VoxelIndex& v) { return std::pair(0.1F * (static_cast<float>(v.z()) + 0.5F), kKnown); });
  return map;
}

TEST(IncompleteSurface, AFloorIsIncompleteAlongItsFrontier) {
  const TsdfMap map = make_half_floor();
  IncompleteSurface surface;
  surface.update(map);
  // Of the lowest empty layer z = 0, the voxels on the border of what is known: x = -4 or 3, y = -4 or 4.
  Voxels expected;
  for (int x = -4; x <= 3; ++x) {
    for (int y = -4; y <= 4; ++y) {
      if (x == -4 || x == 3 || y == -4 || y == 4) expected.insert({x, y, 0});
    }
  }
  EXPECT_EQ(voxels_of(surface, map), expected);
  EXPECT_TRUE(surface.contains({3, 0, 0}));
  EXPECT_FALSE(surface.contains({0, 0, 0})) << "scanned";
  EXPECT_FALSE(surface.contains({3, 0, 1})) << "no surface near";
}

TEST(IncompleteSurface, OnlyTheRegionOfInterestCounts) {
  const TsdfMap map = make_half_floor();
  IncompleteSurface surface(UnknownRule::kSignChange,
                            Eigen::AlignedBox3d(Eigen::Vector3d(0.3, -9, -9), Eigen::Vector3d(9, 0, 9)));
  surface.update(map);
  EXPECT_EQ(voxels_of(surface, map), (Voxels{{3, -4, 0}, {3, -3, 0}, {3, -2, 0}, {3, -1, 0}}));
}

TEST(IncompleteSurface, OverAHalfSpaceTheDirectionIsItsNormal) {
  const TsdfMap map = make_half_floor();
  IncompleteSurface surface;
  surface.update(map);
  for (const auto& element : surface.elements(map)) {
    if (element.voxel.x() != 3 || std::abs(element.voxel.y()) == 4) continue;
    // Six of the 26 are occupied, all one below (x = 4 is unknown): (0, 0), (0, -1), (0, 1), (-1, 0), (-1, -1),
    // (-1, 1). Their unit vectors sum to x = -(1/sqrt(2) + 2/sqrt(3)), z = -(1 + 3/sqrt(2) + 2/sqrt(3)); n is opposed.
    const double s2 = 1 / std::sqrt(2.0), s3 = 1 / std::sqrt(3.0);
    const Eigen::Vector3d expected = Eigen::Vector3d(s2 + 2 * s3, 0, 1 + 3 * s2 + 2 * s3).normalized();
    EXPECT_LT((element.direction - expected).norm(), 1e-9);
    EXPECT_NEAR(element.centre_m.z(), 0.05, 1e-12);
  }
  // A wall whose empty side is +x, all around known but one voxel.
  TsdfMap wall = make_map();
  fill(wall, {-3, -3, -3}, {3, 3, 3},
       [](const VoxelIndex& v) { return std::pair(0.1F * (static_cast<float>(v.x()) + 0.5F), kKnown); });
  set(wall, {1, 0, 0}, 0, 0);
  IncompleteSurface of_wall;
  of_wall.update(wall);
  const auto elements = of_wall.elements(wall);
  const auto found =
      std::find_if(elements.begin(), elements.end(), [](const auto& e) { return e.voxel == VoxelIndex(0, 0, 0); });
  ASSERT_NE(found, elements.end());
  EXPECT_LT((found->direction - Eigen::Vector3d::UnitX()).norm(), 1e-9);
}

/// A wall x < 0 whose hidden voxels at (-1, 0, 0) was seen too seldom to be known, with the given distance.
std::size_t count_with(float hidden_m, float weight, UnknownRule rule) {
  TsdfMap map = make_map();
  fill(map, {-1, -2, -2}, {2, 2, 2},
       [](const VoxelIndex& v) { return std::pair(0.1F * (static_cast<float>(v.x()) + 0.5F), kKnown); });
  set(map, {-1, 0, 0}, hidden_m, weight);
  IncompleteSurface surface(rule, Eigen::AlignedBox3d(Eigen::Vector3d(-0.1, 0, 0), Eigen::Vector3d(0.1, 0.1, 0.1)));
  surface.update(map);
  return surface.size();
}

TEST(IncompleteSurface, WhatIsUnknownBeyondTheRegionLeavesItComplete) {
  TsdfMap map = make_map();
  fill(map, {-1, -2, -2}, {2, 2, 2},
       [](const VoxelIndex& v) { return std::pair(0.1F * (static_cast<float>(v.x()) + 0.5F), kKnown); });
  set(map, {-1, 0, 0}, 0, 0);
  const auto count_in = [&](double least_x_m) {
    IncompleteSurface surface(UnknownRule::kSignChange,
                              Eigen::AlignedBox3d(Eigen::Vector3d(least_x_m, 0, 0), Eigen::Vector3d(0.1, 0.1, 0.1)));
    surface.update(map);
    return surface.size();
  };
  EXPECT_EQ(count_in(-0.1), 1U);
  EXPECT_EQ(count_in(0.0), 0U);
}

TEST(IncompleteSurface, AVoxelSeenSeldomBehindTheSurfaceLeavesItComplete) {
  EXPECT_EQ(count_with(-0.05F, kTooLittle, UnknownRule::kWeight), 1U) << "Def. 1";
  EXPECT_EQ(count_with(-0.05F, kTooLittle, UnknownRule::kSignChange), 0U);
  EXPECT_EQ(count_with(-0.05F, 0.0F, UnknownRule::kSignChange), 1U) << "never seen";
  EXPECT_EQ(count_with(0.05F, kTooLittle, UnknownRule::kSignChange), 1U) << "no surface in between";
  // 0.05 + 0.15 m between neighbours 0.1 m apart: more than a distance field can fall, so these are two surfaces.
  EXPECT_EQ(count_with(-0.15F, kTooLittle, UnknownRule::kSignChange), 1U);
}

TEST(VoxelClasses, KnowTheirNeighboursWhateverTheOrderInWhichBlocksCame) {
  std::mt19937 random(3);
  TsdfMap map = make_map();
  VoxelClasses classes;
  for (int i = 0; i < 20; ++i) {
    disturb(map, random);
    classes.update(map);
  }
  for (const auto& block : classes.blocks()) {
    for (int n = 0; n < 27; ++n) {
      const BlockIndex offset(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      EXPECT_EQ(block->around[static_cast<std::size_t>(n)], classes.find(block->index + offset));
    }
  }
  EXPECT_EQ(classes.at({1000, 0, 0}), VoxelClass::kUnknown);
}

}  // namespace
}  // namespace arpent::mapping
