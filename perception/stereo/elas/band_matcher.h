// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Matches one pyramid level within the candidates of each pixel: census distance plus the neighbourhood's smoothness,
// aggregated along four directions (Hirschmueller, "Stereo processing by semi-global matching and mutual information",
// PAMI 2008, eq. 13) over two bands of eight disparities per pixel instead of the whole range. Its cost does not
// depend on the range. Paths cross from one set of candidates into another by disparity, so that bands may differ.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "perception/stereo/elas/level.h"
#include "perception/stereo/elas/smoothness.h"

namespace arpent::stereo {

struct BandMatcherParams {
  SmoothnessParams smoothness{.step = 8, .jump = 50};
  int threads = 1;
  /// Plain C++ instead of vector code, for comparison.
  bool portable = false;
};

class BandMatcher {
 public:
  struct Workspace;

  explicit BandMatcher(const BandMatcherParams& params);
  ~BandMatcher();
  BandMatcher(const BandMatcher&) = delete;
  BandMatcher& operator=(const BandMatcher&) = delete;

  /// `left`, `right`: 8-bit images of one size. `candidates` covers the left image in blocks. `match` is written whole.
  /// The result does not depend on the number of threads.
  void match(const cv::Mat1b& left, const cv::Mat1b& right, const CandidateGrid& candidates, LevelMatch& match);

 private:
  BandMatcherParams params_;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace arpent::stereo
