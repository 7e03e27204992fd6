// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Disparity to depth: z = B f / d (thesis App. A.2.2, eq. A.12 with d = u_left - u_right).
#pragma once

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {

/// Depth of every pixel of `px128` (unit 1/128 px, kMissing where there is none) whose depth lies in [min_range_m,
/// max_range_m], with its deviation sigma_z = z^2 sigma_d / (B f); the rest is missing. `sigma_px`: deviation of the
/// disparity, same size [px].
[[nodiscard]] DepthMap depth_from_disparity(const cv::Mat1w& px128, const cv::Mat1f& sigma_px,
                                            const RectifiedStereo& stereo, double min_range_m, double max_range_m);

}  // namespace arpent::stereo
