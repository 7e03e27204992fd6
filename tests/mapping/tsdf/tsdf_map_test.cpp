// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/tsdf_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/error.h"

namespace arpent::mapping {
namespace {

const PinholeCamera kCamera{160, 128, 94, 94, 79.5, 63.5};

/// What the camera sees of the plane n . p = d (in its own frame), with the deviation of disparity noise.
stereo::DepthMap see_plane(const Eigen::Vector3d& n, double d) {
  stereo::DepthMap depth{kCamera, cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.0F),
                         cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.0F)};
  for (int v = 0; v < kCamera.height_px; ++v) {
    for (int u = 0; u < kCamera.width_px; ++u) {
      const double z = d / n.dot(kCamera.unproject(u, v, 1.0));
      if (z < 0.1 || z > 50) continue;
      depth.depth_m(v, u) = static_cast<float>(z);
      depth.sigma_m(v, u) = static_cast<float>(1e-3 * z * z);
    }
  }
  return depth;
}
stereo::DepthMap see_wall(double z) {
  return see_plane({0, 0, 1}, z);
}

TsdfParams params(double voxel_m = 0.1) {
  TsdfParams p;
  p.voxel_m = voxel_m;
  return p;
}

TEST(TsdfMap, OneLookMakesAVoxelKnownUpToTheRangeThatTheThresholdAllows) {
  // 1 / z^2 >= 0.3 up to z = 1.826 m (spec of the thesis).
  TsdfMap map(params(0.02));
  ASSERT_TRUE(map.integrate(see_wall(4.0), Pose::Identity()));
  EXPECT_TRUE(map.is_known(map.index_of({0.01, 0.01, 1.80})));
  EXPECT_FALSE(map.is_known(map.index_of({0.01, 0.01, 1.85})));
  EXPECT_TRUE(map.voxel(map.index_of({0.01, 0.01, 1.85}))) << "seen, but not yet known";
  EXPECT_FALSE(map.voxel(map.index_of({0.01, 0.01, 4.5}))) << "behind the wall nothing was seen";
}

TEST(TsdfMap, DistanceAndWeightAreTheWeightedMeanOfEquation12) {
  TsdfMap map(params());
  const VoxelIndex index = map.index_of({0.05, 0.05, 1.95});
  const Eigen::Vector3d centre = map.centre_m(index);
  (void)map.integrate(see_wall(2.0), Pose::Identity());
  (void)map.integrate(see_wall(2.1), Pose::Identity());
  const double w = 1.0 / centre.squaredNorm();
  const double first = 2.0 - centre.z(), second = 2.1 - centre.z();
  EXPECT_NEAR(map.voxel(index)->weight, 2 * w, 1e-4);
  EXPECT_NEAR(map.voxel(index)->distance_m, 0.5 * (first + second), 1e-3);
}

TEST(TsdfMap, DistancesToASlantedPlaneAreThoseAcrossIt) {
  const Eigen::Vector3d n = Eigen::Vector3d(0.1, 0.95, 0.25).normalized();  // a floor seen at a grazing angle
  const double d = 0.8;
  TsdfMap map(params());
  (void)map.integrate(see_plane(n, d), Pose::Identity());
  int compared = 0;
  for (int k = 8; k < 30; ++k) {
    for (int j = 0; j < 12; ++j) {
      for (int i = -6; i < 6; ++i) {
        const auto voxel = map.voxel({i, j, k});
        if (!voxel) continue;
        const double truth = std::min(d - n.dot(map.centre_m({i, j, k})), 0.3);
        EXPECT_NEAR(voxel->distance_m, truth, 0.01) << i << ' ' << j << ' ' << k;
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 300);
}

/// There the weight of eq. 1.2 has dropped to 0. Clutter, which is not fitted, and lengths that are sums of powers of
/// two: the distance is exact.
TEST(TsdfMap, AVoxelThatLiesExactlyTheTruncationDistanceBehindASurfaceHasNoDistance) {
  TsdfParams p = params(0.125);
  p.truncation_voxels = 1;
  TsdfMap map(p);
  stereo::DepthMap clutter = see_wall(2.0);
  for (int v = 0; v < kCamera.height_px; ++v) {
    for (int u = v % 2; u < kCamera.width_px; u += 2) clutter.depth_m(v, u) = 3.0F;
  }
  const Pose T_map_cam(Eigen::Translation3d(0, 0, 0.0625));
  (void)map.integrate(clutter, T_map_cam);  // voxels' centres lie 0.125 k from the camera
  (void)map.integrate(clutter, Pose(Eigen::Translation3d(0, 0, 0.1)));
  int seen = 0;
  for (int k = 0; k < 24; ++k) {
    for (int j = -8; j < 8; ++j) {
      for (int i = -8; i < 8; ++i) {
        const auto voxel = map.voxel({i, j, k});
        if (!voxel) continue;
        ASSERT_TRUE(std::isfinite(voxel->distance_m)) << i << ' ' << j << ' ' << k;
        ASSERT_GT(voxel->weight, 0);
        ++seen;
      }
    }
  }
  EXPECT_GT(seen, 1000);
}

TEST(TsdfMap, TheMapDoesNotDependOnTheNumberOfThreads) {
  std::vector<std::uint32_t> digests;
  for (const int threads : {1, 2, 4}) {
    TsdfParams p = params(0.05);
    p.threads = threads;
    TsdfMap map(p);
    for (int i = 0; i < 3; ++i) {
      Pose pose(Eigen::AngleAxisd(0.2 * i, Eigen::Vector3d::UnitY()));
      (void)map.integrate(see_wall(2.0 + 0.1 * i), pose);
    }
    digests.push_back(map.digest());
  }
  EXPECT_EQ(digests[0], digests[1]);
  EXPECT_EQ(digests[0], digests[2]);
}

TEST(TsdfMap, TheDigestTellsMapsApart) {
  TsdfMap a(params()), b(params());
  EXPECT_EQ(a.digest(), b.digest());
  (void)a.integrate(see_wall(2.0), Pose::Identity());
  (void)b.integrate(see_wall(2.0), Pose::Identity());
  EXPECT_EQ(a.digest(), b.digest());
  (void)b.integrate(see_wall(2.01), Pose::Identity());
  EXPECT_NE(a.digest(), b.digest());
}

TEST(TsdfMap, WhatHasMovedAwayIsCarvedOut) {
  TsdfMap map(params());
  (void)map.integrate(see_wall(1.5), Pose::Identity());
  const VoxelIndex behind_front = map.index_of({0.05, 0.05, 1.55});
  EXPECT_LE(map.voxel(behind_front)->distance_m, 0);
  for (int i = 0; i < 10; ++i) (void)map.integrate(see_wall(3.0), Pose::Identity());
  EXPECT_GT(map.voxel(behind_front)->distance_m, 0);
}

TEST(TsdfMap, KnownVoxelsAreCountedAsTheyCome) {
  TsdfMap map(params());
  for (int i = 0; i < 3; ++i) (void)map.integrate(see_wall(2.0), Pose::Identity());
  std::size_t known = 0;
  for (int k = -8; k < 40; ++k) {
    for (int j = -40; j < 40; ++j) {
      for (int i = -40; i < 40; ++i) known += map.is_known({i, j, k}) ? 1U : 0U;
    }
  }
  EXPECT_EQ(map.known_voxel_count(), known);
  EXPECT_GT(known, 100U);
}

TEST(TsdfMap, WhatIsBeyondTheRangeIsNoSurfaceButUpToThereNothingIsInTheWay) {
  TsdfMap map(params());
  // 1 / 4.5^2 = 0.049: seven looks make 0.35 of the 0.3 that are needed.
  for (int i = 0; i < 7; ++i) ASSERT_TRUE(map.integrate(see_wall(8.0), Pose::Identity()));
  for (const double z : {0.55, 2.05, 4.45}) {
    const VoxelIndex index = map.index_of({0.05, 0.05, z});
    EXPECT_TRUE(map.is_known(index)) << z;
    EXPECT_GT(map.voxel(index)->distance_m, 0.25) << "truncated at three voxels";
  }
  for (const double z : {5.15, 7.95, 8.05}) EXPECT_FALSE(map.voxel(map.index_of({0.05, 0.05, z}))) << z;
  // A wall a little beyond: empty space ends with the range, and near the wall says how near.
  TsdfMap near(params());
  for (int i = 0; i < 9; ++i) ASSERT_TRUE(near.integrate(see_wall(5.1), Pose::Identity()));
  EXPECT_NEAR(near.voxel(near.index_of({0.05, 0.05, 4.95}))->distance_m, 0.15, 1e-3);
  EXPECT_FALSE(near.voxel(near.index_of({0.05, 0.05, 5.05})));
}

TEST(TsdfMap, WhatCannotBeUsedChangesNothing) {
  TsdfMap map(params());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  stereo::DepthMap depth = see_wall(2.0);
  depth.depth_m.setTo(nan);
  EXPECT_TRUE(map.integrate(depth, Pose::Identity()));
  depth.depth_m.setTo(std::numeric_limits<float>::infinity());
  EXPECT_TRUE(map.integrate(depth, Pose::Identity()));
  EXPECT_EQ(map.block_count(), 0U);
  Pose far = Pose::Identity();
  far.translation().x() = 1e12;
  EXPECT_FALSE(map.integrate(see_wall(2.0), far));
  far.translation().x() = nan;
  EXPECT_FALSE(map.integrate(see_wall(2.0), far));
  Pose stretched = Pose::Identity();
  stretched.linear() *= 2;
  EXPECT_FALSE(map.integrate(see_wall(2.0), stretched));
  depth = see_wall(2.0);
  depth.camera.width_px = 100;
  EXPECT_FALSE(map.integrate(depth, Pose::Identity()));
  EXPECT_EQ(map.block_count(), 0U);
}

TEST(TsdfMap, AFullMapSaysSoAndStaysWithinItsBound) {
  TsdfParams p = params();
  p.max_blocks = 5;
  TsdfMap map(p);
  (void)map.integrate(see_wall(2.0), Pose::Identity());
  EXPECT_EQ(map.block_count(), 5U);
  EXPECT_GT(map.refused_blocks(), 0);
}

TEST(TsdfMap, ImpossibleParametersAreOneClearError) {
  TsdfParams p = params();
  p.voxel_m = -1;
  EXPECT_THROW(TsdfMap{p}, InputError);
}

}  // namespace
}  // namespace arpent::mapping
