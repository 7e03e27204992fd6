// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/tsdf/map_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "common/error.h"
#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

namespace fs = std::filesystem;

class MapFileTest : public testing::Test {
 protected:
  fs::path file_ = fs::path(testing::TempDir()) /
                   (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".map");

  static TsdfMap make_map(int side_px) {
    TsdfParams params;
    params.voxel_m = 0.2;
    TsdfMap map(params);
    const PinholeCamera camera{side_px, side_px, 0.6 * side_px, 0.6 * side_px, 0.5 * side_px, 0.5 * side_px};
    stereo::DepthMap depth{camera, cv::Mat1f(side_px, side_px, 2.3F), cv::Mat1f(side_px, side_px, 0.01F)};
    Pose pose(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
    (void)map.integrate(depth, pose);
    (void)map.integrate(depth, pose);
    return map;
  }
  static std::string content(const fs::path& file) {
    std::stringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  static void put(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }
};

TEST_F(MapFileTest, AMapComesBackWithinTheStatedTolerance) {
  const TsdfMap map = make_map(96);
  save_map(file_, map);
  const LoadedMap loaded = load_map(file_);
  EXPECT_EQ(loaded.lost_blocks, 0U);
  ASSERT_EQ(loaded.map.block_count(), map.block_count());
  EXPECT_EQ(loaded.map.known_voxel_count(), map.known_voxel_count());
  const double truncation = map.storage().truncation_m();
  for (const auto& block : map.storage().blocks) {
    const Block* other = loaded.map.storage().find(block->index);
    ASSERT_NE(other, nullptr);
    for (std::size_t i = 0; i < kBlockVoxels; ++i) {
      EXPECT_EQ(other->weight[i] > 0, block->weight[i] > 0);
      if (block->weight[i] <= 0) continue;
      EXPECT_NEAR(other->distance_m[i], block->distance_m[i], truncation / 2047 * 1.01);
      EXPECT_EQ(other->distance_m[i] > 0, block->distance_m[i] > 0);
      EXPECT_LT(std::abs(std::log2(other->weight[i] / block->weight[i])), 1.0 / 8 + 1e-4);
    }
  }
}

TEST_F(MapFileTest, SavingWhatWasLoadedGivesTheSameBytes) {
  save_map(file_, make_map(96));
  const std::string first = content(file_);
  save_map(file_, load_map(file_).map);
  EXPECT_EQ(content(file_), first);
}

TEST_F(MapFileTest, EveryFlippedByteAndEveryPrefixGivesAnErrorOrTheIntactRest) {
  const TsdfMap map = make_map(32);
  save_map(file_, map);
  const std::string whole = content(file_);
  const auto judge = [&](const std::string& damaged) {
    put(file_, damaged);
    try {
      const LoadedMap loaded = load_map(file_);
      EXPECT_LE(loaded.map.block_count(), map.block_count());
      EXPECT_EQ(loaded.lost_blocks, map.block_count() - loaded.map.block_count());
      EXPECT_EQ(loaded.report.empty(), loaded.lost_blocks == 0);
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(file_.string()), std::string::npos);
    }
  };
  for (std::size_t at = 0; at < whole.size(); at += 1) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0xFF);
    judge(damaged);
    if (at % 3 == 0) judge(whole.substr(0, at));
  }
}

TEST_F(MapFileTest, WhatIsNoMapIsOneClearError) {
  EXPECT_THROW((void)load_map("/no/such/map"), InputError);
  put(file_, "hello");
  EXPECT_THROW((void)load_map(file_), InputError);
  put(file_, std::string(1000, 'x'));
  EXPECT_THROW((void)load_map(file_), InputError);
}

}  // namespace
}  // namespace arpent::mapping
