// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures for the stereo tests.
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace arpent::stereo {

/// Smoothed noise: rich, aperiodic texture.
inline cv::Mat1b texture(int rows, int cols, int seed) {
  cv::Mat1b image(rows, cols);
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {5, 5}, 1.0);
  return image;
}

}  // namespace arpent::stereo
