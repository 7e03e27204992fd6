// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the stages of the matcher hand to each other: the match of one pyramid level, and the candidates of the next.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {

/// Match of one pyramid level, in the left image. `px128` in 1/128 px of this level, kMissing where the best candidate
/// fails the left/right check. `sharpness`: by how much the sum of costs rises one disparity beside the minimum; 0
/// where missing, and where another disparity is about as good.
struct LevelMatch {
  cv::Mat1w px128;
  cv::Mat1b sharpness;
};

/// Lanes of one band, and of the two bands of a pixel.
inline constexpr int kBandWidth = 8;
inline constexpr int kLanes = 2 * kBandWidth;
/// Pixels share their bands in blocks of this edge.
inline constexpr int kBlock = 4;

/// The candidates of a block: disparities low .. low + 7 and high .. high + 7 [px], with low + 8 <= high.
struct Bands {
  std::int16_t low = 0;
  std::int16_t high = kBandWidth;

  friend bool operator==(const Bands&, const Bands&) = default;
  [[nodiscard]] int disparity(int lane) const { return lane < kBandWidth ? low + lane : high + lane - kBandWidth; }
};

/// Bands of all blocks of an image, row by row.
struct CandidateGrid {
  int cols = 0;
  int rows = 0;
  std::vector<Bands> bands;

  [[nodiscard]] const Bands* row(int block_row) const {
    return bands.data() + static_cast<std::ptrdiff_t>(block_row) * cols;
  }
};

}  // namespace arpent::stereo
