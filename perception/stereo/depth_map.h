// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The value types that stereo hands on: disparity and depth images.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "common/camera.h"

namespace arpent::stereo {

/// Disparity d = u_left - u_right per pixel of the left image, as on the wire: unit 1/128 px, `kMissing` where there is
/// none.
inline constexpr std::uint16_t kMissing = 0xFFFF;
inline constexpr float kUnitsPerPixel = 128.0F;
/// Largest disparity that fits [px].
inline constexpr int kMaxDisparityPx = 511;

/// Depth image of a rectified left camera. `depth_m` is z along the optical axis, 0 where missing; `sigma_m` is its
/// standard deviation, same size, 0 where missing. Both are continuous CV_32F images of the camera's size.
struct DepthMap {
  PinholeCamera camera;
  cv::Mat1f depth_m;
  cv::Mat1f sigma_m;
};

}  // namespace arpent::stereo
