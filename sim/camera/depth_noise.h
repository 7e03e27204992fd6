// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Depth as the thesis' numerical experiments have it (Sect. 2.6.1): exact depth with Gaussian noise that grows with the
// square of the distance, smoothed by a 3 x 3 Gaussian filter.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace arpent::sim {

struct NoisyDepth {
  cv::Mat1f depth_m;  ///< along the optical axis, 0 where nothing is within range
  cv::Mat1f sigma_m;  ///< standard deviation before smoothing, 0 where missing
};

/// sigma(z) = |e_d| z^2 / (f B), e_d = 0.1 px (spec: thesis eq. in Sect. 2.6.1); `Bf_px_m` is f B. The filter does not
/// cross edges: neighbours whose depth differs by more than 5 % do not count. The same arguments give the same bytes.
[[nodiscard]] NoisyDepth add_depth_noise(const cv::Mat1f& exact_m, double Bf_px_m, double min_range_m,
                                         double max_range_m, std::uint64_t seed);

}  // namespace arpent::sim
