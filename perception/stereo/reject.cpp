// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/reject.h"

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {
namespace {

constexpr int kTextureReach = 10;
constexpr int kTextureContrast = 4;

}  // namespace

void remove_speckles(cv::Mat1w& px128, int min_pixels) {
  // OpenCV's filter takes signed numbers: 1/16 px reach 2047 px.
  constexpr int kPerUnit = 8;
  constexpr short kNone = -1;
  cv::Mat1s px16(px128.size());
  for (int v = 0; v < px128.rows; ++v) {
    const std::uint16_t* from = px128[v];
    short* to = px16[v];
    for (int u = 0; u < px128.cols; ++u) to[u] = from[u] == kMissing ? kNone : static_cast<short>(from[u] / kPerUnit);
  }
  cv::filterSpeckles(px16, kNone, min_pixels, kUnitsPerPixel / kPerUnit);
  px128.setTo(kMissing, px16 == kNone);
}

cv::Mat1b find_texture(const cv::Mat1b& image) {
  cv::Mat1b smallest;
  cv::Mat1b largest;
  const cv::Mat kernel = cv::getStructuringElement(cv::MORPH_RECT, {2 * kTextureReach + 1, 2 * kTextureReach + 1});
  cv::erode(image, smallest, kernel);
  cv::dilate(image, largest, kernel);
  return (largest - smallest) > kTextureContrast;
}

}  // namespace arpent::stereo
