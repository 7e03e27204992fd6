// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A run-time check of rectification: how far the right image sits above or below the left one. Half a pixel already
// costs more than the choice of the matcher.
#pragma once

#include <opencv2/core.hpp>

namespace arpent::stereo {

/// Median vertical offset (right minus left, positive downwards) [px] over well-textured pixels whose disparity `px128`
/// is known, searched from -3 to 3 px and interpolated; NaN if fewer than 50 pixels can tell.
[[nodiscard]] double measure_vertical_offset_px(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1w& px128);

}  // namespace arpent::stereo
