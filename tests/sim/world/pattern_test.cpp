// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/pattern.h"

#include <gtest/gtest.h>

#include <cmath>

namespace arpent::sim {
namespace {

constexpr int kSide = 512;

double at(const std::vector<float>& tile, int u, int v) {
  return static_cast<double>(tile[static_cast<std::size_t>((v & (kSide - 1)) * kSide + (u & (kSide - 1)))]);
}

/// Mean squared difference over a distance: the structure function.
double structure(const std::vector<float>& tile, int distance) {
  double sum = 0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) sum += std::pow(at(tile, u, v) - at(tile, u + distance, v), 2);
  }
  return sum / (kSide * kSide);
}

TEST(Pattern, EveryKindHasZeroMeanAndUnitDeviation) {
  for (const std::string& kind : pattern_kinds()) {
    const auto tile = make_pattern(kind, 7, 2.0, kSide);
    double sum = 0, squares = 0;
    for (const float x : tile) {
      sum += static_cast<double>(x);
      squares += static_cast<double>(x) * static_cast<double>(x);
    }
    EXPECT_NEAR(sum / (kSide * kSide), 0, 1e-3) << kind;
    EXPECT_NEAR(squares / (kSide * kSide), kind == "plain" ? 0 : 1, 1e-3) << kind;
  }
}

TEST(Pattern, SameSeedSameTileOtherSeedOtherTile) {
  for (const std::string kind : {"concrete", "mat", "carton", "wood"}) {
    EXPECT_EQ(make_pattern(kind, 7, 2.0, 256), make_pattern(kind, 7, 2.0, 256)) << kind;
    EXPECT_NE(make_pattern(kind, 7, 2.0, 256), make_pattern(kind, 8, 2.0, 256)) << kind;
  }
}

/// Photographs have contrast at all sizes: differences grow with distance, neither white noise (they would not) nor a
/// smooth gradient (they would grow as the square).
TEST(Pattern, SurfacesAreRoughAtAllSizesAsPhotographsAre) {
  for (const std::string kind : {"concrete", "plaster", "stone"}) {
    const auto tile = make_pattern(kind, 3, 2.0, kSide);
    for (const int distance : {2, 4, 8, 16}) {
      const double growth = structure(tile, 2 * distance) / structure(tile, distance);
      EXPECT_GT(growth, 1.05) << kind << " " << distance;
      EXPECT_LT(growth, 3.3) << kind << " " << distance;
    }
  }
}

/// Across the border differences are as inside; brightness of speckled floors is uneven, with tails.
TEST(Pattern, TilesHaveNoSeam) {
  for (const std::string kind : {"concrete", "asphalt", "plaster", "rubber", "fabric"}) {
    const auto tile = make_pattern(kind, 3, 2.0, kSide);
    double border = 0;
    for (int v = 0; v < kSide; ++v) border += std::pow(at(tile, kSide - 1, v) - at(tile, 0, v), 2);
    EXPECT_LT(border / kSide, 2.5 * structure(tile, 1)) << kind;
  }
}

TEST(Pattern, SeamsOfMatsAreAMetreApart) {
  const auto tile = make_pattern("mat", 3, 4.0, kSide);
  std::vector<double> columns(kSide, 0);
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) columns[static_cast<std::size_t>(u)] += at(tile, u, v) / kSide;
  }
  for (int u = 0; u < kSide; u += kSide / 4) EXPECT_LT(columns[static_cast<std::size_t>(u)], -3) << u;
  EXPECT_GT(columns[kSide / 8], -1.5) << "between seams";
}

}  // namespace
}  // namespace arpent::sim
