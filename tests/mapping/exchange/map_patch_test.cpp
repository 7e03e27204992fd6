// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/map_patch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "mapping/exchange/block_code.h"
#include "mapping/exchange/patch_builder.h"

namespace arpent::mapping {
namespace {

const PinholeCamera kCamera{160, 128, 94, 94, 79.5, 63.5};

TsdfParams params() {
  TsdfParams p;
  p.voxel_m = 0.1;
  return p;
}

Pose camera_at(const Pose2& body) {
  Eigen::Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  Pose T_body_cam = Pose::Identity();
  T_body_cam.linear() = R;
  T_body_cam.translation() = Eigen::Vector3d(0, 0, 0.4);
  return body.to_pose() * T_body_cam;
}

/// The inside of a room [-4, 4] x [-3, 3] x [0, 2.5].
stereo::DepthMap look(const Pose& T_map_cam) {
  stereo::DepthMap depth{kCamera, cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.0F),
                         cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.01F)};
  const Eigen::Vector3d low(-4, -3, 0), high(4, 3, 2.5), o = T_map_cam.translation();
  for (int v = 0; v < kCamera.height_px; ++v) {
    for (int u = 0; u < kCamera.width_px; ++u) {
      const Eigen::Vector3d d = T_map_cam.linear() * kCamera.unproject(u, v, 1.0);
      double z = 100;
      for (int k = 0; k < 3; ++k) {
        if (std::abs(d[k]) > 1e-9) z = std::min(z, ((d[k] > 0 ? high[k] : low[k]) - o[k]) / d[k]);
      }
      depth.depth_m(v, u) = static_cast<float>(z);
    }
  }
  return depth;
}

std::vector<Pose2> drive(double y_m, double yaw_rad, int images) {
  std::vector<Pose2> poses;
  for (int i = 0; i < images; ++i) poses.push_back({-2 + 0.1 * i, y_m, yaw_rad + 0.1 * i});
  return poses;
}

struct Team {
  TsdfMap central{params()};
  std::vector<MapPatch> patches;
};

/// Two robots drive through the room; the same images go into one map, and into patches.
Team drive_two_robots() {
  Team team;
  for (int r = 0; r < 2; ++r) {
    PatchBuilder builder({}, params(), r == 0 ? "R1" : "R2", "world");
    for (const Pose2& body : drive(r == 0 ? -1.0 : 1.0, r == 0 ? -0.4 : 2.0, 20)) {
      const stereo::DepthMap depth = look(camera_at(body));
      EXPECT_TRUE(team.central.integrate(depth, camera_at(body)));
      for (MapPatch& patch : builder.add({Time{}, depth, camera_at(body), body, 0.01, 0.002})) {
        team.patches.push_back(std::move(patch));
      }
    }
  }
  return team;
}

TEST(MapPatch, TheFusedMapEqualsTheMapIntegratedCentrallyToWithinTheCodesSteps) {
  const Team team = drive_two_robots();
  TsdfMap fused(params());
  for (const MapPatch& patch : team.patches) ASSERT_TRUE(fuse(fused, patch)) << patch.sequence;
  ASSERT_EQ(fused.block_count(), team.central.block_count());
  // Half a step of 1/16 octave in weight, of 1/127 of the truncation distance in distance; all terms of a weighted mean
  // err by no more than that, apart from weights of a mean being off by their step.
  const double weight_step = std::exp2(0.5 / 16) - 1, distance_step_m = 0.3 / 127;
  std::size_t compared = 0, flipped = 0;
  for (const auto& block : team.central.storage().blocks) {
    const Block* other = fused.storage().find(block->index);
    ASSERT_NE(other, nullptr);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      const float w = block->weight[i];
      ASSERT_EQ(w > 0, other->weight[i] > 0) << "seen in one and not in the other";
      if (w < 0.01F || w > 50) continue;
      EXPECT_NEAR(other->weight[i], w, 1.05 * weight_step * w + 8 * kLeastCodedWeight);
      EXPECT_NEAR(other->distance_m[i], block->distance_m[i], distance_step_m + 0.3 * 2 * weight_step);
      flipped += (w >= 0.3F) != (other->weight[i] >= 0.3F) ? 1 : 0;
      ++compared;
    }
  }
  EXPECT_GT(compared, 20000U);
  EXPECT_LT(flipped, compared / 50) << "known or not differs only at the threshold";
}

TEST(MapPatch, TheOrderOfPatchesDoesNotMatterAndAPatchTwiceIsTakenOnce) {
  Team team = drive_two_robots();
  TsdfMap first(params()), second(params());
  for (const MapPatch& patch : team.patches) ASSERT_TRUE(fuse(first, patch));
  std::mt19937 random(3);
  std::vector<MapPatch> shuffled = team.patches;
  shuffled.insert(shuffled.end(), team.patches.begin(), team.patches.end());
  std::shuffle(shuffled.begin(), shuffled.end(), random);
  PatchLedger ledger;
  for (const MapPatch& patch : shuffled) {
    if (!ledger.add(patch.source, patch.sequence)) continue;
    ASSERT_TRUE(fuse(second, patch));
  }
  EXPECT_EQ(first.known_voxel_count(), second.known_voxel_count());
  for (const auto& block : first.storage().blocks) {
    const Block* other = second.storage().find(block->index);
    ASSERT_NE(other, nullptr);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      ASSERT_NEAR(block->weight[i], other->weight[i], 1e-4F * block->weight[i]);
      ASSERT_NEAR(block->distance_m[i], other->distance_m[i], 1e-4F);
    }
  }
}

TEST(MapPatch, SamplesAreSmallAndTheLastOneTellsWhereTheImagesWereTaken) {
  const Team team = drive_two_robots();
  std::size_t bodies = 0, bytes = 0;
  for (const MapPatch& patch : team.patches) {
    EXPECT_LE(patch.blocks.size(), 7500U);
    EXPECT_EQ(patch.position_sigma_m, 0.01);
    bodies += patch.bodies.size();
    bytes += patch.blocks.size();
  }
  EXPECT_EQ(bodies, 40U);
  const std::size_t floats = 8 * kBlockVoxels * 8 * drive_two_robots().central.block_count();
  EXPECT_LT(bytes, floats / 10) << "eight patches against eight times the map as floats";
}

TEST(MapPatch, ARobotThatStandsStopsSendingTheSameView) {
  PatchBuilder builder({}, params(), "R1", "world");
  const Pose2 body{0, 0, 0.3};
  const stereo::DepthMap depth = look(camera_at(body));
  std::size_t images = 0;
  for (int i = 0; i < 60; ++i) {
    for (const MapPatch& patch : builder.add({Time{}, depth, camera_at(body), body, 0, 0}))
      images += patch.bodies.size();
  }
  EXPECT_EQ(images, 20U);
}

TEST(MapPatch, DamagedSamplesAreRefusedWholeAndChangeNothing) {
  const Team team = drive_two_robots();
  TsdfMap map(params());
  ASSERT_TRUE(fuse(map, team.patches[0]));
  const std::uint32_t before = map.digest();
  std::mt19937 random(7);
  int refused = 0;
  for (int trial = 0; trial < 300; ++trial) {
    MapPatch bad = team.patches[1];
    if (trial % 3 == 0) {
      bad.blocks.resize(random() % bad.blocks.size());
    } else {
      for (int k = 0; k < 4; ++k) bad.blocks[random() % 40] ^= static_cast<std::uint8_t>(1 + random() % 255);
    }
    TsdfMap target(params());
    const auto fused = fuse(target, bad);
    if (fused) continue;  // a change that still makes sense is the checksum's to find (wire)
    ++refused;
    EXPECT_EQ(target.block_count(), 0U);
    EXPECT_FALSE(fused.fault().empty());
  }
  EXPECT_GT(refused, 100);
  MapPatch coarse = team.patches[1];
  coarse.voxel_m = 0.2;
  EXPECT_FALSE(fuse(map, coarse));
  EXPECT_EQ(map.digest(), before);
}

TEST(PatchLedger, KnowsWhatIsMissing) {
  PatchLedger ledger;
  for (const int s : {0, 1, 4, 3, 7}) EXPECT_TRUE(ledger.add("R1", s));
  EXPECT_FALSE(ledger.add("R1", 3));
  EXPECT_FALSE(ledger.add("R1", 0));
  EXPECT_TRUE(ledger.add("R2", 0));
  EXPECT_EQ(ledger.missing("R1"), (std::vector<std::int64_t>{2, 5, 6}));
  EXPECT_TRUE(ledger.missing("R2").empty());
  EXPECT_TRUE(ledger.missing("R3").empty());
}

}  // namespace
}  // namespace arpent::mapping
