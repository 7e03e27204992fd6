// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/mip_map.h"

#include <gtest/gtest.h>

#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

std::vector<float> random_values(int count) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i) values.push_back(gaussian_of(9, static_cast<std::uint32_t>(i)));
  return values;
}

float value_at(const MipMap& map, float u, float v, float level) {
  std::array<float, 8> us, vs, values;
  us.fill(u);
  vs.fill(v);
  map.sample(us, vs, level, values);
  for (const float value : values) EXPECT_EQ(value, values[0]);
  return values[0];
}

TEST(MipMap, TexelCentresGiveTheTexelsAndBetweenThemIsLinear) {
  const auto values = random_values(32 * 16);
  const MipMap map(32, 16, values);
  EXPECT_EQ(map.levels(), 6);
  for (int v = 0; v < 16; ++v) {
    for (int u = 0; u < 32; ++u) {
      const auto i = static_cast<std::size_t>(32 * v + u), right = static_cast<std::size_t>(32 * v + (u + 1) % 32);
      const float x = (static_cast<float>(u) + 0.5F) / 32, y = (static_cast<float>(v) + 0.5F) / 16;
      EXPECT_NEAR(value_at(map, x, y, 0), values[i], 2e-4F);
      EXPECT_NEAR(value_at(map, x + 0.25F / 32, y, 0), 0.75F * values[i] + 0.25F * values[right], 2e-4F);
      EXPECT_NEAR(value_at(map, x - 3, y + 2, 0), values[i], 3e-4F) << "repeats";
    }
  }
}

TEST(MipMap, ALevelIsTheMeanOfItsFourChildrenAndTheLastTheMeanOfAll) {
  const auto values = random_values(16 * 16);
  const MipMap map(16, 16, values);
  const float mean = 0.25F * (values[16 * 4 + 6] + values[16 * 4 + 7] + values[16 * 5 + 6] + values[16 * 5 + 7]);
  EXPECT_NEAR(value_at(map, 7.0F / 16, 5.0F / 16, 1), mean, 3e-4F);
  float sum = 0;
  for (const float value : values) sum += value;
  EXPECT_NEAR(value_at(map, 0.3F, 0.8F, 99), sum / 256, 5e-4F);
  const float half_way = 0.5F * (value_at(map, 0.3F, 0.8F, 1) + value_at(map, 0.3F, 0.8F, 2));
  EXPECT_NEAR(value_at(map, 0.3F, 0.8F, 1.5F), half_way, 1e-5F);
}

}  // namespace
}  // namespace arpent::sim
