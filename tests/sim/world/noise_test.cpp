// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/noise.h"

#include <gtest/gtest.h>

#include <bit>

namespace arpent::sim {
namespace {

TEST(SimNoise, EachInputBitChangesHalfTheOutputBits) {
  for (unsigned bit = 0; bit < 32; ++bit) {
    int changed = 0;
    for (std::uint32_t i = 0; i < 2000; ++i)
      changed += std::popcount(mix_bits(i * 77) ^ mix_bits((i * 77) ^ (1U << bit)));
    EXPECT_NEAR(changed / 2000.0, 16, 1) << "bit " << bit;
  }
}

TEST(SimNoise, GaussianHasZeroMeanUnitDeviationAndIndependentNeighbours) {
  constexpr int kCount = 200000;
  double sum = 0, squares = 0, neighbours = 0, tail = 0, last = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = static_cast<double>(gaussian_of(5, static_cast<std::uint32_t>(i)));
    sum += x;
    squares += x * x;
    neighbours += x * last;
    tail += std::abs(x) > 1.96 ? 1 : 0;
    last = x;
  }
  EXPECT_NEAR(sum / kCount, 0, 0.01);
  EXPECT_NEAR(squares / kCount, 1, 0.01);
  EXPECT_NEAR(neighbours / kCount, 0, 0.01);
  EXPECT_NEAR(tail / kCount, 0.05, 0.006) << "as many beyond 1.96 as the normal distribution has";
}

}  // namespace
}  // namespace arpent::sim
