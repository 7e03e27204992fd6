// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What cameras send, as 8-bit grey. Deeper pixels keep their eight highest bits (Mono12: value / 16, rounded down);
// colour, Bayer mosaics and packed formats are refused, because a stereo matcher must not see a mosaic.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <string>

#include "common/result.h"

namespace arpent::camera {

/// How grey lies in memory.
struct GrayLayout {
  int bits = 8;   ///< that carry the value, the lowest of the pixel
  int bytes = 1;  ///< from one pixel to the next; little-endian
};

/// Of a GenICam pixel format (PFNC 32-bit value, e.g. 0x01080001 = Mono8), or why it cannot be used.
[[nodiscard]] Result<GrayLayout> genicam_layout(std::uint32_t pixel_format);
/// Of a V4L2 pixel format (four characters: GREY, Y10, Y12, Y16, or YUYV, whose luminance is taken), or why not.
[[nodiscard]] Result<GrayLayout> v4l2_layout(std::uint32_t fourcc);
[[nodiscard]] std::string fourcc_text(std::uint32_t fourcc);

/// A copy as 8-bit grey. `row_bytes`: from one row to the next. A fault if `data` is too short for the size.
[[nodiscard]] Result<cv::Mat> to_gray8(std::span<const std::uint8_t> data, cv::Size size_px, std::size_t row_bytes,
                                       GrayLayout layout);
/// The same of a decoded file: CV_8UC1, or CV_16UC1 with 16 bits.
[[nodiscard]] Result<cv::Mat> to_gray8(const cv::Mat& image);

}  // namespace arpent::camera
