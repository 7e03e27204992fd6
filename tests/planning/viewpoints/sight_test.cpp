// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rays and gains against brute force: samples along each segment, projection of each voxel.
#include "planning/viewpoints/sight.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/planning/viewpoints/scene.h"

namespace arpent::planning {
namespace {

using mapping::VoxelClass;

/// A cloud of empty voxels with holes and obstacles.
mapping::TsdfMap make_clutter(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> dice(0, 99);
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-4, -4, -4), Eigen::Vector3d(4, 4, 4));
  return make_scene(box, [&](const Eigen::Vector3d&) {
    const int d = dice(random);
    return d < 3 ? Content::kOccupied : d < 6 ? Content::kUnknown : Content::kEmpty;
  });
}

TEST(Trace, MeetsWhatDenseSamplesOfTheSegmentMeet) {
  const auto map = make_clutter(1);
  mapping::VoxelClasses classes;
  classes.update(map);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> at(-22, 22);
  int blocked = 0, unknown = 0, clear = 0;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d from(at(random), at(random), at(random));
    const Eigen::Vector3d to = from + 0.3 * Eigen::Vector3d(at(random), at(random), at(random));
    const Trace met = trace(classes, from, to);
    constexpr int kSamples = 20000;
    int first_occupied = kSamples + 1, first_unknown = kSamples + 1;
    for (int s = kSamples; s >= 0; --s) {
      const Eigen::Vector3d p = from + s / static_cast<double>(kSamples) * (to - from);
      const VoxelClass c = classes.at(p.array().floor().cast<int>());
      if (c == VoxelClass::kOccupied) first_occupied = s;
      if (c == VoxelClass::kUnknown) first_unknown = s;
    }
    if (first_occupied <= kSamples) {
      ASSERT_TRUE(met.occupied) << i;
    }
    if (met.occupied && first_occupied > kSamples) continue;  // a corner between two samples
    if (first_unknown < first_occupied && first_unknown <= kSamples) {
      // The walk may know of an earlier voxel whose corner the samples stepped over, no later one.
      ASSERT_LE(met.clear_share, (first_unknown + 1.0) / kSamples) << i;
    }
    blocked += met.occupied ? 1 : 0;
    unknown += met.clear_share < 1 ? 1 : 0;
    clear += !met.occupied && met.clear_share >= 1 ? 1 : 0;
  }
  EXPECT_GT(blocked, 50);
  EXPECT_GT(unknown, 50);
  EXPECT_GT(clear, 20);
}

TEST(Trace, TellsWhereTheUnknownBegins) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 2, 2));
  const auto map =
      make_scene(box, [](const Eigen::Vector3d& p) { return p.x() < 1 ? Content::kEmpty : Content::kUnknown; });
  mapping::VoxelClasses classes;
  classes.update(map);
  // Voxels 0 .. 4 along x are empty: from 0.5 to 10.5, the wall at 5 is at 4.5 of 10.
  const Trace met = trace(classes, {0.5, 5.5, 5.5}, {10.5, 5.5, 5.5});
  EXPECT_FALSE(met.occupied);
  EXPECT_NEAR(met.clear_share, 0.45, 1e-12);
  EXPECT_EQ(trace(classes, {0.5, 5.5, 5.5}, {4.9, 5.5, 5.5}).clear_share, 1);
  EXPECT_EQ(trace(classes, {-5, 5.5, 5.5}, {4.9, 5.5, 5.5}).clear_share, 0) << "it begins where no block is";
}

/// Behind the corner of what it saw, a camera leaves "occupied" voxels in free space.
TEST(Trace, WhatIsOnlyInferredToBeOccupiedBlocksOrIsUnknown) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 2, 2));
  for (const float distance_m : {-0.1F, -0.19F, -0.21F, -0.5F}) {
    auto map =
        make_scene(box, [](const Eigen::Vector3d& p) { return p.x() < 1 ? Content::kEmpty : Content::kOccupied; });
    for (const auto& block : map.storage().blocks) {
      for (float& d : block->distance_m) d = d < 0 ? distance_m : d;
    }
    mapping::VoxelClasses classes;
    classes.update(map);
    const Eigen::Vector3d from(0.5, 5.5, 5.5), to(8.5, 5.5, 5.5);
    EXPECT_TRUE(trace(classes, from, to).occupied);
    const Trace met = trace(classes, from, to, Inferred::kIsUnknown);
    EXPECT_EQ(met.occupied, distance_m > -0.2F) << "a voxel below the surface: " << distance_m;
    if (!met.occupied) {
      EXPECT_NEAR(met.clear_share, 4.5 / 8, 1e-12);
    }
  }
}

/// A wall x > 4 known for |y| < 3, before it a box that hides some of it.
mapping::TsdfMap make_wall() {
  const Eigen::AlignedBox3d known(Eigen::Vector3d(-1, -3, 0), Eigen::Vector3d(4.4, 3, 2.4));
  const Eigen::AlignedBox3d box(Eigen::Vector3d(2.4, 0.8, 0), Eigen::Vector3d(3.0, 2.0, 1.0));
  return make_scene(known, [&](const Eigen::Vector3d& p) {
    return p.x() > 4 || box.contains(p) ? Content::kOccupied : Content::kEmpty;
  });
}

TEST(Sight, SeesTheElementsThatProjectIntoBothImagesWithNothingInBetween) {
  const auto map = make_wall();
  mapping::IncompleteSurface surface;
  surface.update(map);
  const LevelCamera camera = rig_camera();
  const Sight sight(camera, surface, map);
  std::size_t seen_count = 0, hidden_count = 0, judged = 0;
  for (const Pose2& pose : {Pose2{0, 0, 0}, Pose2{0.5, 1.5, 0.4}, Pose2{0.2, -1, -0.7}}) {
    const auto seen = sight.see_elements(pose);
    const Pose T_cam_map = (pose.to_pose() * T_body_rig()).inverse();
    const Eigen::Vector3d eye = T_cam_map.inverse().translation();
    for (std::uint32_t i = 0; i < sight.elements().size(); ++i) {
      const Eigen::Vector3d p = sight.elements()[i].centre_m;
      const Eigen::Vector3d p_cam = T_cam_map * p;
      const Eigen::Vector2d left = rig_stereo().camera.project(p_cam);
      const double right_px = left.x() - 377 * 0.26 / p_cam.z();
      bool expected = p_cam.z() >= 0.3 && p_cam.z() <= 5 && right_px >= -0.5 && left.x() <= 639.5 && left.y() >= -0.5 &&
                      left.y() <= 511.5;
      double clearance = 1;  // how near a sample comes to a voxel's border where that would matter is not judged
      for (int s = 0; expected && s <= 4000; ++s) {
        const double t = 0.3 / p_cam.z() + (1 - 0.3 / p_cam.z()) * s / 4000;
        const Eigen::Vector3d q = eye + t * (p - eye);
        if (surface.classes().at(map.index_of(q)) != VoxelClass::kEmpty) expected = false;
        for (const double shift : {-0.002, 0.002}) {
          for (int k = 0; k < 3; ++k) {
            const Eigen::Vector3d beside = q + shift * Eigen::Vector3d::Unit(k);
            if (surface.classes().at(map.index_of(beside)) != VoxelClass::kEmpty) clearance = 0;
          }
        }
      }
      const bool is_seen = std::binary_search(seen.begin(), seen.end(), i);
      seen_count += is_seen ? 1 : 0;
      hidden_count += is_seen ? 0 : 1;
      if (clearance > 0) {
        EXPECT_EQ(is_seen, expected) << p.transpose();
        ++judged;
      }
    }
  }
  EXPECT_GT(seen_count, 30U);
  EXPECT_GT(hidden_count, 30U);
  EXPECT_GT(judged, (seen_count + hidden_count) / 2);
}

TEST(Sight, LooksWeighByTheSquareOfTheDistance) {
  const auto map = make_wall();
  mapping::IncompleteSurface surface;
  surface.update(map);
  const LevelCamera camera = rig_camera();
  const Sight sight(camera, surface, map);
  const Pose2 pose{1.0, 0, 0};
  const auto looks = sight.look_at_unknowns(pose, 0.5);
  ASSERT_FALSE(looks.empty());
  for (const Look& look : looks) {
    const UnknownVoxel& unknown = sight.unknowns()[look.unknown];
    EXPECT_EQ(unknown.missing_weight, 0.3) << "never seen, W_th = 0.3";
    const double z2 = (unknown.centre_m - camera.position_m(pose)).squaredNorm();
    EXPECT_NEAR(look.share, 1 / (z2 * 0.3), 1e-6);
  }
  // One look completes below 1.826 m and eight do at 5 m (thesis Sect. 2.4.1).
  EXPECT_NEAR(1 / (1.8257 * 1.8257 * 0.3), 1.0, 1e-3);
  EXPECT_EQ(std::ceil(5.0 * 5.0 * 0.3), 8);
}

TEST(Sight, NearTheFloorOnlyWhatIsCloseIsMeasured) {
  const LevelCamera camera = rig_camera();
  const auto map = make_wall();
  mapping::IncompleteSurface surface;
  surface.update(map);
  const Sight sight(camera, surface, map);
  // 0.1 m above a floor and 0.4 m below the camera: a ray through it meets the floor at 4/3 of its depth, so within
  // 5 m from a depth of 3.75 m on.
  UnknownVoxel unknown;
  unknown.above_surface_m = 0.1;
  const CameraView view(camera, {0, 0, 0});
  unknown.centre_m = Eigen::Vector3d(0.2 + 3.7, 0, 0.1);
  EXPECT_TRUE(sight.measures(view, unknown));
  unknown.centre_m.x() = 0.2 + 3.8;
  EXPECT_FALSE(sight.measures(view, unknown));
  // The top of a box above the camera.
  unknown.centre_m = Eigen::Vector3d(1.5, 0, 1.1);
  EXPECT_FALSE(sight.measures(view, unknown));
  unknown.above_surface_m = -0.05;
  EXPECT_TRUE(sight.measures(view, unknown)) << "behind the surface, where depth ends";
}

}  // namespace
}  // namespace arpent::planning
