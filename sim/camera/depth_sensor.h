// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A depth sensor without a matcher: true depth with the noise of stereo, for missions that sense depth directly (the
// thesis' numerical experiments, Sect. 2.6.1).
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace arpent::sim {

struct DepthNoise {
  double disparity_error_px = 0.1;  ///< |e_d|
  double focal_px = 377;
  double baseline_m = 0.26;
  double min_range_m = 0.3;
  double max_range_m = 40.0;  ///< beyond the range of surfaces (Table 5.3): it tells what is free
};

/// Depth along the optical axis and its standard deviation; both 0 where nothing is measured.
struct NoisyDepth {
  cv::Mat1f depth_m;
  cv::Mat1f sigma_m;
};

/// sigma(z) = |e_d| z^2 / (f B); independent Gaussian noise of this deviation, then a 3 x 3 Gaussian filter
/// (1 2 1; 2 4 2; 1 2 1) / 16 that leaves out neighbours beyond a depth edge, so that no depth arises between two
/// surfaces. `sigma_m` is the deviation after the filter. Depths out of range are not measured.
[[nodiscard]] NoisyDepth sense_depth(const cv::Mat1f& true_depth_m, const DepthNoise& noise, std::uint64_t seed);

}  // namespace arpent::sim
