// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How noisy an image is, told from the image alone, so that matching can prepare for dark corners.
#pragma once

#include <opencv2/core.hpp>

namespace arpent::stereo {

/// Standard deviation of the pixel noise [grey levels], at least 3 x 3 pixels. The response to a mask that is blind to
/// planes of brightness (Immerkaer, "Fast noise variance estimation", CVIU 1996); its lower quantile stands for the
/// smooth part of the image, so that texture hardly counts. Zero for an image whose smooth part is saturated.
[[nodiscard]] double estimate_noise(const cv::Mat1b& image);

}  // namespace arpent::stereo
