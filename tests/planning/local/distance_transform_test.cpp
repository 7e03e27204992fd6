// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/distance_transform.h"

#include <gtest/gtest.h>

#include <random>

namespace arpent::planning {
namespace {

std::int32_t brute_force(const std::vector<std::uint8_t>& marked, int cols, int rows, int x, int y) {
  std::int32_t least = kNoneMarked;
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < cols; ++i) {
      if (marked[static_cast<std::size_t>(j * cols + i)] == 0) continue;
      least = std::min(least, (x - i) * (x - i) + (y - j) * (y - j));
    }
  }
  return least;
}

TEST(DistanceTransform, EqualsBruteForceOnRandomGrids) {
  std::mt19937 random(1);
  for (int trial = 0; trial < 60; ++trial) {
    const int cols = 1 + static_cast<int>(random() % 40), rows = 1 + static_cast<int>(random() % 40);
    const unsigned one_in = 1 + random() % 200;
    std::vector<std::uint8_t> marked(static_cast<std::size_t>(cols * rows));
    for (auto& m : marked) m = random() % one_in == 0 ? 1 : 0;
    const auto squared = squared_distances(marked, cols, rows);
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < cols; ++x) {
        ASSERT_EQ(squared[static_cast<std::size_t>(y * cols + x)], brute_force(marked, cols, rows, x, y))
            << cols << " x " << rows << " at " << x << ", " << y;
      }
    }
  }
}

TEST(DistanceTransform, NothingMarkedIsNowhereNear) {
  const std::vector<std::uint8_t> marked(12);
  for (const std::int32_t d : squared_distances(marked, 4, 3)) EXPECT_EQ(d, kNoneMarked);
}

}  // namespace
}  // namespace arpent::planning
