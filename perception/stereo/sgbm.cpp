// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/sgbm.h"

#include <opencv2/calib3d.hpp>

#include "perception/stereo/alignment.h"
#include "perception/stereo/fill.h"
#include "perception/stereo/reject.h"

namespace arpent::stereo {
namespace {

constexpr int kBlock = 3;
/// OpenCV counts in 1/16 px.
constexpr int kUnitsPerOpenCvUnit = 8;
/// Median |error| of semi-global matching where it is right is about 0.2 px on textured public pairs: one figure for
/// all pixels, as it has no measure.
constexpr float kSigmaPx = 0.3F;
/// On wide-SIMD builds OpenCV falls to scalar code unless the range is a multiple of this.
constexpr int kRangeMultiple = 32;

class SgbmMatcher : public StereoMatcher {
 public:
  explicit SgbmMatcher(const MatcherParams& params)
      : max_disparity_px_(params.max_disparity_px),
        range_((params.max_disparity_px + kRangeMultiple - 1) / kRangeMultiple * kRangeMultiple),
        sgbm_(cv::StereoSGBM::create(0, range_, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock, 1, 63, 10, 100, 32,
                                     cv::StereoSGBM::MODE_SGBM_3WAY)) {}

  Disparities match(const cv::Mat1b& left, const cv::Mat1b& right) override {
    cv::setNumThreads(1);
    cv::Mat1s raw;
    sgbm_->compute(pad(left), pad(right), raw);
    Disparities result;
    result.trusted = to_units(raw);
    remove_unconfirmed(left, right, result.trusted);
    result.filled = result.trusted.clone();
    fill_from_background(result.filled);
    result.sigma_px = cv::Mat1f(left.size(), 0.0F);
    result.sigma_px.setTo(kSigmaPx, result.trusted != kMissing);
    result.vertical_offset_px = measure_vertical_offset_px(left, right, result.trusted);
    return result;
  }

 private:
  [[nodiscard]] cv::Mat pad(const cv::Mat1b& image) const {
    cv::Mat padded;
    cv::copyMakeBorder(image, padded, 0, 0, range_, 0, cv::BORDER_REPLICATE);
    return padded;
  }

  /// Cuts the padding off and drops what cannot be trusted: beyond the range, out of the right image, or without
  /// texture (where the least cost says nothing).
  [[nodiscard]] cv::Mat1w to_units(const cv::Mat1s& raw) const {
    cv::Mat1w units(raw.rows, raw.cols - range_, kMissing);
    for (int v = 0; v < units.rows; ++v) {
      for (int u = 0; u < units.cols; ++u) {
        const int d = raw(v, u + range_) * kUnitsPerOpenCvUnit;
        if (d < 0 || d >= max_disparity_px_ * 128 || d > u * 128) continue;
        units(v, u) = static_cast<std::uint16_t>(d);
      }
    }
    return units;
  }

  int max_disparity_px_;
  int range_;
  cv::Ptr<cv::StereoSGBM> sgbm_;
};

}  // namespace

std::unique_ptr<StereoMatcher> make_sgbm_matcher(const MatcherParams& params) {
  return std::make_unique<SgbmMatcher>(params);
}

}  // namespace arpent::stereo
