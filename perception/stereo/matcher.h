// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The stereo matcher's interface: a rectified grey pair in, two disparity images out. `filled` has a value wherever
// anything can be said (pictures, initialisation); `trusted` only where the measurement is reliable: missing means
// missing, because invented depth becomes an obstacle in the map.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>

#include "common/config/fields.h"
#include "perception/stereo/depth_map.h"

namespace arpent::stereo {

struct MatcherParams {
  std::string algorithm = "elas";
  int max_disparity_px = 128;
  int threads = 1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("algorithm", self.algorithm, "stereo matcher", config::one_of({"elas", "sgbm"}));
    visitor.field("max_disparity_px", self.max_disparity_px, "disparities searched: 0 .. max_disparity_px - 1",
                  config::between(16, kMaxDisparityPx));
    visitor.field("threads", self.threads, "threads of one match; the result does not depend on it",
                  config::between(1, 16));
  }
};

struct Disparities {
  cv::Mat1w filled;           ///< unit 1/128 px, kMissing where nothing can be said
  cv::Mat1w trusted;          ///< unit 1/128 px, a subset of reliable measurements
  cv::Mat1f sigma_px;         ///< standard deviation of `trusted` [px], 0 where missing
  double vertical_offset_px;  ///< median vertical misalignment of the pair (right minus left), NaN if it cannot be told
};

class StereoMatcher {
 public:
  virtual ~StereoMatcher() = default;
  /// `left`, `right`: rectified 8-bit images of one size, at least 32 x 32. A pair without texture gives images full of
  /// kMissing. Deterministic: the same pair gives the same bytes whatever was matched before and with any number of
  /// threads.
  [[nodiscard]] virtual Disparities match(const cv::Mat1b& left, const cv::Mat1b& right) = 0;
};

/// Throws InputError for parameters that break their rules.
[[nodiscard]] std::unique_ptr<StereoMatcher> make_matcher(const MatcherParams& params);

}  // namespace arpent::stereo
