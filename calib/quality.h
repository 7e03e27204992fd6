// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How good a calibration is, in numbers and in plain words: what the views covered, what the parameters' deviations
// mean in pixels, whether one half of the views predicts the other, and what to do next.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/stereo.h"

namespace arpent::calib {

inline constexpr int kCoverageColumns = 10;
inline constexpr int kCoverageRows = 8;

struct CameraQuality {
  double rms_px = 0;
  double alone_rms_px = 0;      ///< fitted without the other cameras
  cv::Mat1f coverage;           ///< corners per field of the image, kCoverageRows x kCoverageColumns
  double coverage_percent = 0;  ///< fields with corners
  cv::Mat1f uncertainty_px;     ///< deviation of the projection, per field; empty without covariance
  double worst_uncertainty_px = 0;
  double focal_deviation_percent = 0;
};

enum class Grade { kGood, kUsable, kBad };

struct Quality {
  std::vector<CameraQuality> cameras;
  double tilt_deg = 0;         ///< largest angle between two views of the board
  double epipolar_rms_px = 0;  ///< distance from the epipolar line, cameras 0 and 1; 0 for one camera
  double holdout_ratio = 0;    ///< rms of views that were not used over that of those used; 0: too few views
  Grade grade = Grade::kGood;
  std::vector<std::string> advice;  ///< what keeps it from being good, and what to do, worst first
};

[[nodiscard]] Quality assess(const Calibration& calibration);
/// "good", "usable" or "bad".
[[nodiscard]] const char* to_text(Grade grade);

/// Counts corners per field of an image into `coverage`, kCoverageRows x kCoverageColumns.
void add_coverage(const Corners& corners, const CameraInput& camera, cv::Mat1f& coverage);
/// The part of the image (a ninth) that has fewest fields with corners, in words: "upper left".
[[nodiscard]] std::string emptiest_part(const cv::Mat1f& coverage);

/// Deviation [px] with which a far point is projected at each field's centre. What a small turn of the camera would
/// explain does not count: a turned frame is no error of the lens. `covariance` of the 8 lens parameters.
[[nodiscard]] cv::Mat1f projection_uncertainty(const RawCamera& camera, const Eigen::MatrixXd& covariance);

}  // namespace arpent::calib
