// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a matcher throws away after matching: small pieces that nothing supports, and pixels where there was nothing to
// match.
#pragma once

#include <opencv2/core.hpp>

namespace arpent::stereo {

/// Sets pieces of fewer than `min_pixels` 4-connected pixels, whose neighbours differ by at most one pixel of
/// disparity, to kMissing.
void remove_speckles(cv::Mat1w& px128, int min_pixels);

/// Not 0 at pixels within 10 px of a difference of more than 4 grey levels.
[[nodiscard]] cv::Mat1b find_texture(const cv::Mat1b& image);

}  // namespace arpent::stereo
