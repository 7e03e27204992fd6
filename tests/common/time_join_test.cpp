// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/time_join.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>

namespace arpent {
namespace {

using Join = TimeJoin<int, int>;
using namespace std::chrono_literals;

Time at(int ms) {
  return Time(std::chrono::milliseconds(ms));
}

std::vector<std::tuple<Time, int, int>> flat(const std::vector<Join::Joined>& joined) {
  std::vector<std::tuple<Time, int, int>> result;
  for (const auto& j : joined) result.emplace_back(j.stamp, j.left, j.right.value_or(-1));
  return result;
}

TEST(TimeJoin, TheResultDoesNotDependOnWhichStreamIsAhead) {
  // Left every 200 ms, right every 100 ms; random interleavings that keep each stream's own order.
  std::vector<std::tuple<Time, int, int>> expected;
  for (int ms = 0; ms < 3000; ms += 200) expected.emplace_back(at(ms), ms, ms + 1);
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 generator(seed);
    Join join(10s);
    std::vector<std::tuple<Time, int, int>> got;
    int left_ms = 0;
    int right_ms = 0;
    while (left_ms < 3000 || right_ms < 3000) {
      const bool left = right_ms >= 3000 || (left_ms < 3000 && generator() % 3 == 0);
      if (left) {
        ASSERT_TRUE(join.push_left(at(left_ms), left_ms));
        left_ms += 200;
      } else {
        ASSERT_TRUE(join.push_right(at(right_ms), right_ms + 1));
        right_ms += 100;
      }
      for (const auto& item : flat(join.take())) got.push_back(item);
    }
    EXPECT_EQ(got, expected) << "seed " << seed;
  }
}

TEST(TimeJoin, ALeftItemThatTheRightStreamPassesIsGivenOutUnpaired) {
  Join join(10s);
  ASSERT_TRUE(join.push_left(at(100), 1));
  EXPECT_TRUE(join.take().empty());
  ASSERT_TRUE(join.push_right(at(50), 0));
  EXPECT_TRUE(join.take().empty()) << "the right stream may still bring 100";
  ASSERT_TRUE(join.push_right(at(150), 0));
  EXPECT_EQ(flat(join.take()), (std::vector<std::tuple<Time, int, int>>{{at(100), 1, -1}}));
}

TEST(TimeJoin, ALeftItemBehindTheHorizonIsGivenOutUnpaired) {
  Join join(1s);
  ASSERT_TRUE(join.push_left(at(0), 1));
  ASSERT_TRUE(join.push_left(at(1000), 2));
  EXPECT_TRUE(join.take().empty());
  ASSERT_TRUE(join.push_left(at(1001), 3));
  EXPECT_EQ(join.take().size(), 1U);
  EXPECT_EQ(join.waiting(), 2U);
}

TEST(TimeJoin, AStreamThatGoesBackIsRefused) {
  Join join(1s);
  ASSERT_TRUE(join.push_left(at(10), 1));
  EXPECT_FALSE(join.push_left(at(10), 1));
  EXPECT_FALSE(join.push_left(at(9), 1));
  ASSERT_TRUE(join.push_right(at(10), 1));
  EXPECT_FALSE(join.push_right(at(9), 1));
}

}  // namespace
}  // namespace arpent
