// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Resampling of an 8-bit image through a fixed map, bilinear. OpenCV's remap does the same at three times the cost
// (bench `elas`, `rectify.ms_pair`): its maps take six bytes a pixel, ours four, and rectification is bound by memory.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace arpent::stereo {

class Remap {
 public:
  Remap() = default;
  /// `u`, `v`: for each pixel of the result, where it lies in the source [px], pixel centres at whole numbers. `source`
  /// is the size of the images to come; throws InputError above 2000 x 2000. Positions are rounded to 1/32 px.
  Remap(const cv::Mat1f& u, const cv::Mat1f& v, const cv::Size& source);

  /// `image` has the source's size. Black where the map points beyond it. `portable` picks the plain twin of the vector
  /// code; both give the same bytes.
  [[nodiscard]] cv::Mat1b apply(const cv::Mat1b& image, bool portable = false) const;

 private:
  cv::Size source_;
  cv::Mat1i positions_;  ///< 32 v in the upper 16 bits, 32 u in the lower, in the padded source
};

}  // namespace arpent::stereo
