// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace arpent::planning {
namespace {

using mapping::VoxelIndex;

TEST(Pieces, CornersHangTogetherGapsDoNot) {
  const auto sizes = piece_sizes(std::vector<VoxelIndex>{{0, 0, 0}, {1, 1, 1}, {3, 1, 1}, {4, 0, 2}, {9, 9, 9}});
  EXPECT_EQ(sizes, (std::vector<std::size_t>{2, 2, 2, 2, 1}));
  EXPECT_TRUE(piece_sizes({}).empty());
}

TEST(Pieces, WhatDoesNotCountJoinsNoOthers) {
  const std::vector<VoxelIndex> line{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_EQ(piece_sizes(line, std::vector<std::uint8_t>{1, 0, 1, 1}), (std::vector<std::size_t>{1, 0, 2, 2}));
}

TEST(Pieces, AreThoseOfRepeatedRelabelling) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> coordinate(-6, 6);
  std::vector<VoxelIndex> voxels;
  for (int i = 0; i < 150; ++i) {
    const VoxelIndex v(coordinate(random), coordinate(random), coordinate(random));
    if (std::find(voxels.begin(), voxels.end(), v) == voxels.end()) voxels.push_back(v);
  }
  // The slow way: neighbours take the smaller label until nothing changes.
  std::vector<std::size_t> label(voxels.size());
  for (std::size_t i = 0; i < label.size(); ++i) label[i] = i;
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      for (std::size_t j = 0; j < voxels.size(); ++j) {
        if ((voxels[i] - voxels[j]).cwiseAbs().maxCoeff() > 1 || label[j] >= label[i]) continue;
        label[i] = label[j];
        changed = true;
      }
    }
  }
  const auto sizes = piece_sizes(voxels);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    EXPECT_EQ(sizes[i], static_cast<std::size_t>(std::count(label.begin(), label.end(), label[i])));
  }
}

}  // namespace
}  // namespace arpent::planning
