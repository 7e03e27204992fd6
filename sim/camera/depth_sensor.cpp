// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/depth_sensor.h"

#include <array>
#include <cmath>

#include "sim/world/noise.h"

namespace arpent::sim {
namespace {

constexpr float kEdgeShare = 0.05F;  ///< neighbours whose true depths differ by more lie on another surface
constexpr std::array<float, 3> kWeights{1, 2, 1};

}  // namespace

NoisyDepth sense_depth(const cv::Mat1f& true_depth_m, const DepthNoise& noise, std::uint64_t seed) {
  const auto scale = static_cast<float>(noise.disparity_error_px / (noise.focal_px * noise.baseline_m));
  const auto least = static_cast<float>(noise.min_range_m), most = static_cast<float>(noise.max_range_m);
  const auto key = hash_bits(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32) + 0x5EEDU);
  const int rows = true_depth_m.rows, cols = true_depth_m.cols;
  cv::Mat1f noisy(true_depth_m.size());
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < cols; ++u) {
      const float z = true_depth_m(v, u);
      noisy(v, u) = z + scale * z * z * gaussian_of(key, static_cast<std::uint32_t>(v * cols + u));
    }
  }
  NoisyDepth result{cv::Mat1f(true_depth_m.size(), 0.0F), cv::Mat1f(true_depth_m.size(), 0.0F)};
  for (int v = 0; v < rows; ++v) {
    for (int u = 0; u < cols; ++u) {
      const float z = true_depth_m(v, u);
      if (!(z >= least && z <= most)) continue;
      float sum = 0, weights = 0, squares = 0;
      for (int dv = -1; dv <= 1; ++dv) {
        for (int du = -1; du <= 1; ++du) {
          const int row = v + dv, column = u + du;
          if (row < 0 || row >= rows || column < 0 || column >= cols) continue;
          const float other = true_depth_m(row, column);
          if (!(std::abs(other - z) <= kEdgeShare * z)) continue;
          const float w = kWeights[static_cast<std::size_t>(dv + 1)] * kWeights[static_cast<std::size_t>(du + 1)];
          sum += w * noisy(row, column);
          weights += w;
          squares += w * w;
        }
      }
      result.depth_m(v, u) = sum / weights;
      result.sigma_m(v, u) = scale * z * z * std::sqrt(squares) / weights;
    }
  }
  return result;
}

}  // namespace arpent::sim
