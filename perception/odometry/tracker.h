// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where points go in the images: corners spread over the image, Lucas-Kanade from image to image, and the search for a
// point's partner in the right image. Pure image work: it knows no poses.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace arpent::odometry {

/// An image with the pyramid and gradients that Lucas-Kanade needs, computed once.
struct Pyramid {
  std::vector<cv::Mat> levels;
  std::vector<cv::Mat> steady;  ///< of the image less its local mean; of tracked images only
  cv::Mat1b image;
};
[[nodiscard]] Pyramid make_pyramid(const cv::Mat1b& image);
/// For images from and to which points are followed: what brightness the exposure gives them does not matter.
[[nodiscard]] Pyramid make_tracked_pyramid(const cv::Mat1b& image);

/// Follows `from_px` from one tracked image to another, starting at `guess_px`. nullopt where a point was lost: out of
/// the image, no texture, or an appearance that changed too much.
[[nodiscard]] std::vector<std::optional<cv::Point2f>> track_points(const Pyramid& from, const Pyramid& to,
                                                                   const std::vector<cv::Point2f>& from_px,
                                                                   const std::vector<cv::Point2f>& guess_px);

/// How far the image as a whole has moved from `from` to `to` [px], by phase correlation at a quarter of the
/// resolution.
[[nodiscard]] cv::Point2d measure_shift(const cv::Mat1b& from, const cv::Mat1b& to);

/// Up to `per_cell` strongest Shi-Tomasi corners in each cell of `cell_px` that has fewer than that among `taken_px`,
/// at least `cell_px / 4` apart, at even pixels.
[[nodiscard]] std::vector<cv::Point2f> find_corners(const Pyramid& pyramid, const std::vector<cv::Point2f>& taken_px,
                                                    int cell_px, int per_cell);

/// For each pixel of the left image its column in the right one, searched along the row among disparities 0 to
/// `max_disparity_px` and refined by Lucas-Kanade; nullopt if there is no unique partner on the same row within 1 px.
[[nodiscard]] std::vector<std::optional<float>> match_right(const Pyramid& left, const Pyramid& right,
                                                            const std::vector<cv::Point2f>& left_px,
                                                            int max_disparity_px);
/// The same from a guess of the column, without the search.
[[nodiscard]] std::vector<std::optional<float>> refine_right(const Pyramid& left, const Pyramid& right,
                                                             const std::vector<cv::Point2f>& left_px,
                                                             const std::vector<cv::Point2f>& guess_px);

}  // namespace arpent::odometry
