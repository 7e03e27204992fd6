// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/elas/elas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "perception/stereo/alignment.h"
#include "perception/stereo/elas/band_matcher.h"
#include "perception/stereo/elas/candidates.h"
#include "perception/stereo/elas/coarse.h"
#include "perception/stereo/elas/support.h"
#include "perception/stereo/fill.h"
#include "perception/stereo/noise.h"
#include "perception/stereo/reject.h"

namespace arpent::stereo {
namespace {

/// The top of the pyramid is small and smooth: weaker penalties keep its thin objects.
constexpr SmoothnessParams kCoarseSmoothness{.step = 5, .jump = 30};
constexpr SmoothnessParams kFineSmoothness{.step = 8, .jump = 50};
/// Pieces of fewer pixels than this are dropped, at the top of the pyramid and below.
constexpr int kCoarseSpeckle = 20;
constexpr int kFineSpeckle = 60;

/// Standard deviation of a match by its sharpness [px]: a floor from the pixel grid, and an error in inverse proportion
/// to the slope of the cost. Both figures fit the errors on public pairs (bench `elas`, `elas.sigma_ratio`).
constexpr float kSigmaFloorPx = 0.15F;
constexpr float kSigmaTimesSharpness = 8.0F;

std::array<float, 256> sigma_by_sharpness() {
  std::array<float, 256> sigma{};
  for (std::size_t i = 1; i < sigma.size(); ++i) {
    sigma[i] = std::hypot(kSigmaFloorPx, kSigmaTimesSharpness / static_cast<float>(i));
  }
  return sigma;
}

/// Noise from which on images are smoothed before matching [grey levels], and by how much.
constexpr double kNoticeableNoise = 3.0;
constexpr double kSmoothingPerNoise = 0.25;
constexpr double kMostSmoothingPx = 2.0;

/// The pair as it is or, in the dark, smoothed in proportion to its noise: comparisons of grey levels are what suffers
/// most from noise (bench `elas`, `elas.bad2_noise5`).
std::pair<cv::Mat1b, cv::Mat1b> calm(const cv::Mat1b& left, const cv::Mat1b& right, double noise) {
  if (noise < kNoticeableNoise) return {left, right};
  std::pair<cv::Mat1b, cv::Mat1b> pair;
  const double smoothing_px = std::min(kSmoothingPerNoise * noise, kMostSmoothingPx);
  cv::GaussianBlur(left, pair.first, {5, 5}, smoothing_px);
  cv::GaussianBlur(right, pair.second, {5, 5}, smoothing_px);
  return pair;
}

cv::Mat1b halve(const cv::Mat1b& image) {
  cv::Mat1b half;
  cv::resize(image(cv::Rect(0, 0, image.cols / 2 * 2, image.rows / 2 * 2)), half, {}, 0.5, 0.5, cv::INTER_AREA);
  return half;
}

class ElasMatcher : public StereoMatcher {
 public:
  explicit ElasMatcher(const MatcherParams& params)
      : range_px_(params.max_disparity_px),
        half_matcher_({.smoothness = kFineSmoothness, .threads = params.threads}),
        full_matcher_({.smoothness = kFineSmoothness, .threads = params.threads}) {}

  Disparities match(const cv::Mat1b& left_raw, const cv::Mat1b& right_raw) override {
    cv::setNumThreads(1);
    const double noise = std::max(estimate_noise(left_raw), estimate_noise(right_raw));
    const auto [left, right] = calm(left_raw, right_raw, noise);
    const cv::Mat1b left_half = halve(left);
    const cv::Mat1b right_half = halve(right);
    LevelMatch quarter = match_whole_range(halve(left_half), halve(right_half), range_px_ / 4 + 2, kCoarseSmoothness);
    remove_speckles(quarter.px128, kCoarseSpeckle);

    LevelMatch half;
    half_matcher_.match(left_half, right_half, candidates_from(quarter, left_half.size(), range_px_ / 2 + 2), half);
    remove_speckles(half.px128, kFineSpeckle);

    LevelMatch full;
    full_matcher_.match(left, right, candidates_from(half, left.size(), range_px_), full);
    remove_speckles(full.px128, kFineSpeckle);
    return finish(left_raw, right_raw, full);
  }

 private:
  /// `level` loses its gaps.
  static CandidateGrid candidates_from(LevelMatch& level, const cv::Size& next, int range_px) {
    const cv::Mat1w prior = interpolate_prior(select_support_points(level), level.px128.size());
    fill_from_background(level.px128);
    level.px128.setTo(0, level.px128 == kMissing);
    return propose_candidates(level.px128, prior, next, range_px);
  }

  [[nodiscard]] Disparities finish(const cv::Mat1b& left, const cv::Mat1b& right, LevelMatch& full) const {
    // On the images as they came: smoothed noise is alike more often.
    remove_unconfirmed(left, right, full.px128);
    full.px128.setTo(kMissing, full.px128 >= range_px_ * kUnitsPerPixel);
    Disparities result;
    result.filled = full.px128.clone();
    fill_from_background(result.filled);
    cv::medianBlur(result.filled, result.filled, 3);
    keep_certain(full, result);
    result.vertical_offset_px = measure_vertical_offset_px(left, right, result.trusted);
    return result;
  }

  static void keep_certain(const LevelMatch& full, Disparities& result) {
    result.trusted.create(full.px128.size());
    result.sigma_px.create(full.px128.size());
    const auto sigma = sigma_by_sharpness();
    for (int v = 0; v < full.px128.rows; ++v) {
      const std::uint16_t* px128 = full.px128[v];
      const std::uint8_t* sharpness = full.sharpness[v];
      std::uint16_t* trusted = result.trusted[v];
      float* sigma_px = result.sigma_px[v];
      for (int u = 0; u < full.px128.cols; ++u) {
        trusted[u] = sharpness[u] > 0 ? px128[u] : kMissing;
        sigma_px[u] = trusted[u] != kMissing ? sigma[sharpness[u]] : 0.0F;
      }
    }
  }

  int range_px_;
  BandMatcher half_matcher_;
  BandMatcher full_matcher_;
};

}  // namespace

std::unique_ptr<StereoMatcher> make_elas_matcher(const MatcherParams& params) {
  return std::make_unique<ElasMatcher>(params);
}

}  // namespace arpent::stereo
