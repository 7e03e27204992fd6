// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Matches a small image over its whole disparity range: the top of the pyramid, where the range costs least. The same
// matching cost and smoothness as band_matcher.h, with all disparities as candidates of every pixel.
#pragma once

#include <opencv2/core.hpp>

#include "perception/stereo/elas/level.h"
#include "perception/stereo/elas/smoothness.h"

namespace arpent::stereo {

/// `left`, `right`: 8-bit images of one size. Searches disparities 0 .. `range_px` - 1. One thread.
[[nodiscard]] LevelMatch match_whole_range(const cv::Mat1b& left, const cv::Mat1b& right, int range_px,
                                           const SmoothnessParams& smoothness);

}  // namespace arpent::stereo
