// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/reject.h"

#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {
namespace {

/// Blobs, slopes and holes, in whole units of 8 (1/16 px), so that OpenCV's filter sees the same numbers.
cv::Mat1w make_blobs(std::uint64_t seed, int step) {
  cv::RNG rng(seed);
  cv::Mat1w px128(61, 83);
  for (int v = 0; v < px128.rows; ++v) {
    for (int u = 0; u < px128.cols; ++u) {
      const int plane = 40 * 128 + u * 16;
      const bool missing = rng.uniform(0, 100) < 30;
      px128(v, u) = missing ? kMissing : static_cast<std::uint16_t>(plane + step * rng.uniform(-2, 3));
    }
  }
  return px128;
}

TEST(StereoReject, SpecklesAreThoseOfOpenCvsFilter) {
  for (const int step : {8, 40, 64, 72, 200}) {
    for (const int largest : {0, 1, 5, 20, 60}) {
      cv::Mat1w ours = make_blobs(static_cast<std::uint64_t>(step), step);
      cv::Mat1s theirs(ours.size());
      for (int i = 0; i < static_cast<int>(ours.total()); ++i) {
        theirs(i / ours.cols, i % ours.cols) = ours(i / ours.cols, i % ours.cols) == kMissing
                                                   ? short{-1}
                                                   : static_cast<short>(ours(i / ours.cols, i % ours.cols) / 8);
      }
      remove_speckles(ours, largest);
      cv::filterSpeckles(theirs, -1, largest, 16);
      EXPECT_EQ(cv::countNonZero((ours == kMissing) != (theirs == -1)), 0) << "step " << step << ", " << largest;
    }
  }
}

TEST(StereoReject, APieceThatJoinsOnlyInItsLastRowIsOnePiece) {
  cv::Mat1w px128(5, 7, kMissing);
  for (int v = 0; v < 5; ++v) px128(v, 1) = px128(v, 3) = px128(v, 5) = 1000;
  for (int u = 1; u <= 5; ++u) px128(4, u) = 1000;
  const cv::Mat1w before = px128.clone();
  remove_speckles(px128, 16);
  EXPECT_EQ(cv::countNonZero(px128 != before), 0) << "17 pixels";
  remove_speckles(px128, 17);
  EXPECT_EQ(cv::countNonZero(px128 != kMissing), 0);
}

}  // namespace
}  // namespace arpent::stereo
