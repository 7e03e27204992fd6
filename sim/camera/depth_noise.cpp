// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/depth_noise.h"

#include <array>
#include <cmath>

#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

constexpr float kDisparityNoisePx = 0.1F;
constexpr float kEdgeShare = 0.05F;

/// The 3 x 3 Gaussian (1 2 1)^T (1 2 1) / 16 over what belongs to the same surface.
float smooth(const cv::Mat1f& depth_m, int v, int u) {
  constexpr std::array<float, 3> kWeights{1, 2, 1};
  const float centre = depth_m(v, u);
  float sum = 0, weights = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      if (v + dv < 0 || v + dv >= depth_m.rows || u + du < 0 || u + du >= depth_m.cols) continue;
      const float z = depth_m(v + dv, u + du);
      if (z <= 0 || std::abs(z - centre) > kEdgeShare * centre) continue;
      const float w = kWeights[static_cast<std::size_t>(dv + 1)] * kWeights[static_cast<std::size_t>(du + 1)];
      sum += w * z;
      weights += w;
    }
  }
  return sum / weights;
}

}  // namespace

NoisyDepth add_depth_noise(const cv::Mat1f& exact_m, double Bf_px_m, double min_range_m, double max_range_m,
                           std::uint64_t seed) {
  const auto scale = static_cast<float>(kDisparityNoisePx / Bf_px_m);
  const auto nearest = static_cast<float>(min_range_m), farthest = static_cast<float>(max_range_m);
  const std::uint32_t key = hash_bits(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
  cv::Mat1f noisy(exact_m.size(), 0.0F);
  NoisyDepth result{cv::Mat1f(exact_m.size(), 0.0F), cv::Mat1f(exact_m.size(), 0.0F)};
  for (int v = 0; v < exact_m.rows; ++v) {
    for (int u = 0; u < exact_m.cols; ++u) {
      const float z = exact_m(v, u);
      if (z < nearest || z > farthest) continue;
      const auto counter = static_cast<std::uint32_t>(v * exact_m.cols + u);
      result.sigma_m(v, u) = scale * z * z;
      noisy(v, u) = z + result.sigma_m(v, u) * gaussian_of(key, counter);
    }
  }
  for (int v = 0; v < exact_m.rows; ++v) {
    for (int u = 0; u < exact_m.cols; ++u) {
      if (noisy(v, u) > 0) result.depth_m(v, u) = smooth(noisy, v, u);
    }
  }
  return result;
}

}  // namespace arpent::sim
