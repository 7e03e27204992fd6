// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The four sides of a tag's black square as straight lines, to a few hundredths of a pixel. Across each side, grey
// profiles are sampled; where the profile's mean crosses the middle between its dark and its bright end is the edge, by
// a moment that no symmetric blur shifts; a line is fitted through all of a side. Lines, not corners, are the
// measurement: the two ends of a side share their errors, and a line knows how.
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>

#include "perception/tags/detector.h"

namespace arpent::tags {

/// A side of a tag: the points x with normal . x = offset_px; the normal points out of the black square.
struct TagSide {
  Eigen::Vector2d normal;
  double offset_px = 0;
  /// Covariance [px^2] of the line's distance at the side's first and second corner.
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
};

/// Side k runs from corner k to corner k + 1.
struct TagOutline {
  std::array<TagSide, 4> sides;
  ImageCorners corners_px;  ///< where the sides meet
};

/// Fits the sides, starting from corners that are right to about half a cell (an eighth of a side). nullopt if a side
/// is no edge: hidden in part, not straight, without contrast, outside the image, or too small (cells below 1.6 px).
[[nodiscard]] std::optional<TagOutline> fit_outline(const cv::Mat1b& image, const ImageCorners& corners_px);

}  // namespace arpent::tags
