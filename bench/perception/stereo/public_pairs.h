// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The public stereo pairs with ground truth in $ARPENT_DATA/stereo/pairs, and how a disparity image is scored against
// them. Formats are those of SOURCES.txt beside the data.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace arpent::bench {

struct PublicPair {
  std::string name;
  cv::Mat1b left, right;
  cv::Mat1f truth_px;   ///< infinite where unknown
  cv::Mat1b evaluated;  ///< not 0 where the truth is known and, if the data say so, seen by both cameras
  int range_px;
};

/// teddy, venus, reindeer, cloth3, motorcycleQ, terrace, in this order. Throws InputError if a file is missing.
[[nodiscard]] std::vector<PublicPair> load_public_pairs(const std::string& data_dir);

/// The pair scaled to `size` (disparities with the width); nearest truth.
[[nodiscard]] PublicPair scaled(const PublicPair& pair, const cv::Size& size, int range_px);
[[nodiscard]] PublicPair cropped(const PublicPair& pair, const cv::Rect& rect, int range_px);
/// Gaussian noise on both images.
[[nodiscard]] PublicPair with_noise(const PublicPair& pair, double sigma, std::uint64_t seed);

struct Score {
  double density_percent = 0;
  double bad2_all_percent = 0;  ///< wrong by more than 2 px, or missing
  double bad2_est_percent = 0;  ///< wrong by more than 2 px, among estimated
  double average_px = 0;        ///< mean |error| of estimated
};

/// `px128` as in depth_map.h.
[[nodiscard]] Score score(const PublicPair& pair, const cv::Mat1w& px128);

}  // namespace arpent::bench
