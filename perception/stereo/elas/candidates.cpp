// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/elas/candidates.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

namespace arpent::stereo {
namespace {

/// Neighbourhood that proposes disparities, in pixels of this level beyond the block.
constexpr int kReach = 2;
/// A block of the next level in pixels of this one.
constexpr int kBlockHere = kBlock / 2;
/// Candidates kept below the least and above the greatest proposal.
constexpr int kSlack = 3;

/// Bands that cover proposals from `low` to `high` [px of the next level].
Bands cover(float low, float high, int range_px) {
  int first = 0;
  int second = 0;
  if (high - low <= static_cast<float>(kLanes - 2 * kSlack)) {
    first = static_cast<int>((low + high) / 2 + 0.5F) - kBandWidth;
    second = first + kBandWidth;
  } else {
    first = static_cast<int>(low + 0.5F) - kSlack;
    second = static_cast<int>(high + 0.5F) - (kBandWidth - 1 - kSlack);
  }
  first = std::clamp(first, 0, std::max(range_px - kLanes, 0));
  second = std::clamp(second, first + kBandWidth, std::max(range_px - kBandWidth, first + kBandWidth));
  return {static_cast<std::int16_t>(first), static_cast<std::int16_t>(second)};
}

}  // namespace

CandidateGrid propose_candidates(const cv::Mat1w& px128, const cv::Mat1w& prior, const cv::Size& next, int range_px) {
  // The prior counts in the pixel's own block only: it adds a proposal, it does not spread.
  const cv::Mat window = cv::getStructuringElement(cv::MORPH_RECT, {2 * kReach + kBlockHere, 2 * kReach + kBlockHere});
  const cv::Mat own = cv::getStructuringElement(cv::MORPH_RECT, {kBlockHere, kBlockHere});
  cv::Mat1w nearest;
  cv::Mat1w farthest;
  cv::dilate(px128, nearest, window, {kReach, kReach});
  cv::erode(px128, farthest, window, {kReach, kReach});
  cv::Mat1w with_prior = px128.clone();
  prior.copyTo(with_prior, prior != kMissing);
  CandidateGrid grid{
      .cols = (next.width + kBlock - 1) / kBlock, .rows = (next.height + kBlock - 1) / kBlock, .bands = {}};
  grid.bands.reserve(static_cast<std::size_t>(grid.cols) * static_cast<std::size_t>(grid.rows));
  constexpr float kToNext = 2.0F / kUnitsPerPixel;
  for (int row = 0; row < grid.rows; ++row) {
    const int v = std::min(row * kBlockHere, px128.rows - 1);
    for (int col = 0; col < grid.cols; ++col) {
      const int u = std::min(col * kBlockHere, px128.cols - 1);
      const std::uint16_t extra = with_prior(v, u);
      const std::uint16_t low = std::min(farthest(v, u), extra);
      const std::uint16_t high = std::max(nearest(v, u), extra);
      grid.bands.push_back(cover(static_cast<float>(low) * kToNext, static_cast<float>(high) * kToNext, range_px));
    }
  }
  return grid;
}

}  // namespace arpent::stereo
