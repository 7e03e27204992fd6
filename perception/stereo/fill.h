// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Filling the gaps of a disparity image for those who want a value everywhere.
#pragma once

#include <opencv2/core.hpp>

namespace arpent::stereo {

/// Replaces each gap in a row by the smaller (farther) of the disparities at its two ends: gaps are mostly occlusions,
/// and what is occluded is behind. Rows without any value take the nearest row's above, then below. An image without
/// any value stays empty.
void fill_from_background(cv::Mat1w& px128);

}  // namespace arpent::stereo
