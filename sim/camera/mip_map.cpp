// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/mip_map.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace arpent::sim {
namespace {

using Lanes = std::array<float, 8>;

/// Means of two by two; a side of one stays.
std::vector<float> halve(const std::vector<float>& values, int width, int height) {
  const int half_width = std::max(1, width / 2), half_height = std::max(1, height / 2);
  std::vector<float> half(static_cast<std::size_t>(half_width) * static_cast<std::size_t>(half_height));
  for (int v = 0; v < half_height; ++v) {
    for (int u = 0; u < half_width; ++u) {
      const auto at = [&](int dv, int du) {
        const int row = std::min(2 * v + dv, height - 1), column = std::min(2 * u + du, width - 1);
        return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                      static_cast<std::size_t>(column)];
      };
      half[static_cast<std::size_t>(v) * static_cast<std::size_t>(half_width) + static_cast<std::size_t>(u)] =
          0.25F * (at(0, 0) + at(0, 1) + at(1, 0) + at(1, 1));
    }
  }
  return half;
}

}  // namespace

MipMap::MipMap(int width, int height, const std::vector<float>& values) {
  ARPENT_ASSERT(std::has_single_bit(static_cast<unsigned>(width)) &&
                std::has_single_bit(static_cast<unsigned>(height)));
  ARPENT_ASSERT(values.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  lowest_ = *least;
  scale_ = std::max(1e-6F, *most - *least) / 65535.0F;
  std::vector<float> current = values;
  for (;;) {
    Level level{width, height, width + 1, {}};
    for (int v = 0; v <= height; ++v) {
      for (int u = 0; u <= width; ++u) {
        const float value = current[static_cast<std::size_t>(v % height) * static_cast<std::size_t>(width) +
                                    static_cast<std::size_t>(u % width)];
        level.texels.push_back(static_cast<std::uint16_t>(std::lround((value - lowest_) / scale_)));
      }
    }
    level.texels.push_back(0);  // texels are read in pairs
    levels_.push_back(std::move(level));
    if (width == 1 && height == 1) break;
    current = halve(current, width, height);
    width = std::max(1, width / 2);
    height = std::max(1, height / 2);
  }
}

void MipMap::sample_level(const Level& level, const Lanes& u, const Lanes& v, Lanes& values) {
  std::array<std::int32_t, 8> at;
  Lanes share_u, share_v;
  const auto width = static_cast<float>(level.width), height = static_cast<float>(level.height);
  for (std::size_t i = 0; i < 8; ++i) {
    const float x = u[i] * width - 0.5F, y = v[i] * height - 0.5F;
    const float fx = std::floor(x), fy = std::floor(y);
    share_u[i] = x - fx;
    share_v[i] = y - fy;
    at[i] = (static_cast<std::int32_t>(fy) & (level.height - 1)) * level.stride +
            (static_cast<std::int32_t>(fx) & (level.width - 1));
  }
  std::array<std::uint32_t, 8> upper, lower;
  const std::uint16_t* texels = level.texels.data();
  for (std::size_t i = 0; i < 8; ++i) {
    std::memcpy(&upper[i], texels + at[i], 4);
    std::memcpy(&lower[i], texels + at[i] + level.stride, 4);
  }
  for (std::size_t i = 0; i < 8; ++i) {
    const auto a = static_cast<float>(static_cast<std::int32_t>(upper[i] & 0xFFFFU));
    const auto b = static_cast<float>(static_cast<std::int32_t>(upper[i] >> 16));
    const auto c = static_cast<float>(static_cast<std::int32_t>(lower[i] & 0xFFFFU));
    const auto d = static_cast<float>(static_cast<std::int32_t>(lower[i] >> 16));
    const float top = a + share_u[i] * (b - a), bottom = c + share_u[i] * (d - c);
    values[i] = top + share_v[i] * (bottom - top);
  }
}

void MipMap::sample(const Lanes& u, const Lanes& v, float level, Lanes& values) const {
  const float most = static_cast<float>(levels_.size() - 1);
  const float wanted = std::clamp(level, 0.0F, most);
  const auto finer = static_cast<std::size_t>(wanted);
  const float share = wanted - static_cast<float>(finer);
  sample_level(levels_[finer], u, v, values);
  if (share > 0) {
    Lanes coarse;
    sample_level(levels_[finer + 1], u, v, coarse);
    for (std::size_t i = 0; i < 8; ++i) values[i] += share * (coarse[i] - values[i]);
  }
  for (std::size_t i = 0; i < 8; ++i) values[i] = lowest_ + scale_ * values[i];
}

}  // namespace arpent::sim
