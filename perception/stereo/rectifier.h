// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rectification: turns a raw pair into the pair that an ideal stereo camera with parallel axes would have taken,
// through maps that are computed once. A calibration that is ideal already costs nothing.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <utility>

#include "common/camera.h"
#include "perception/stereo/remap.h"

namespace arpent::stereo {

class Rectifier {
 public:
  /// `calibration` must have no faults (find_faults). The rectified camera has the left camera's size, one focal length
  /// and one principal row for both images (cv::stereoRectify with zero disparity at infinity and no scaling beyond the
  /// valid area).
  explicit Rectifier(const StereoCalibration& calibration);

  [[nodiscard]] const RectifiedStereo& stereo() const { return stereo_; }
  /// Pose of the rectified left camera on the body.
  [[nodiscard]] const Pose& T_body_rectified() const { return T_body_rectified_; }
  /// True if images pass through untouched.
  [[nodiscard]] bool is_identity() const { return identity_; }

  /// 8-bit images of the calibration's size. Untouched images share their memory with the input. Bilinear; black where
  /// nothing was seen.
  [[nodiscard]] std::pair<cv::Mat1b, cv::Mat1b> rectify(const cv::Mat1b& left, const cv::Mat1b& right) const;

 private:
  RectifiedStereo stereo_;
  Pose T_body_rectified_ = Pose::Identity();
  bool identity_ = false;
  std::array<Remap, 2> maps_;
};

}  // namespace arpent::stereo
