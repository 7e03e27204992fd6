// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The descriptor of a pixel: which of the 24 neighbours in its 5 x 5 window are at least as bright as itself. The
// Hamming distance of two descriptors is the matching cost. It ignores gain, offset and vignetting, and a single bright
// pixel changes few bits; on public pairs it beats the Sobel descriptors of the 2010 paper (docs/decisions/0003).
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

namespace arpent::stereo {

/// Greatest distance of two descriptors.
inline constexpr int kCensusBits = 24;

/// One descriptor per pixel in the low 24 bits (source: Zabih and Woodfill, "Non-parametric local transforms", ECCV
/// 1994). The image continues beyond its border with the nearest pixel's value. `descriptors` is reused if it fits.
void compute_census(const cv::Mat1b& image, cv::Mat1i& descriptors);

}  // namespace arpent::stereo
