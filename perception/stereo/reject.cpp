// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/reject.h"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {
namespace {

constexpr int kCells = 11;  // of 2 x 2 pixels: the window's edge
constexpr int kDifferenceReach = 2;
/// Noise matched to noise correlates by less than this, texture as strong as the noise by more.
constexpr float kLeastCorrelation = 0.45F;
constexpr int kUnitsPerWholePixel = 128;
constexpr int kUnitsPerHalfPixel = 64;

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

void remove_unconfirmed(const cv::Mat1b& left, const cv::Mat1b& right, cv::Mat1w& px128) {
  // Differences over a few columns at a pixel and its partner: sums of their squares and their products, in cells of
  // 2 x 2 pixels (a quarter of the filtering; bench `elas`).
  const cv::Size cells((left.cols + 1) / 2, (left.rows + 1) / 2);
  cv::Mat1f left_energy(cells, 0.0F);
  cv::Mat1f right_energy(cells, 0.0F);
  cv::Mat1f common(cells, 0.0F);
  for (int v = 0; v < left.rows; ++v) {
    const std::uint8_t* l = left[v];
    const std::uint8_t* r = right[v];
    const std::uint16_t* d = px128[v];
    for (int u = kDifferenceReach; u + kDifferenceReach < left.cols; ++u) {
      const int partner = u - (d[u] + kUnitsPerHalfPixel) / kUnitsPerWholePixel;
      if (d[u] == kMissing || partner < kDifferenceReach || partner + kDifferenceReach >= left.cols) continue;
      const auto a = static_cast<float>(l[u + kDifferenceReach] - l[u - kDifferenceReach]);
      const auto b = static_cast<float>(r[partner + kDifferenceReach] - r[partner - kDifferenceReach]);
      left_energy(v / 2, u / 2) += a * a;
      right_energy(v / 2, u / 2) += b * b;
      common(v / 2, u / 2) += a * b;
    }
  }
  for (cv::Mat1f* sum : {&left_energy, &right_energy, &common}) cv::boxFilter(*sum, *sum, CV_32F, {kCells, kCells});
  for (int v = 0; v < left.rows; ++v) {
    for (int u = 0; u < left.cols; ++u) {
      const float energy = left_energy(v / 2, u / 2) * right_energy(v / 2, u / 2);
      const float c = std::max(common(v / 2, u / 2), 0.0F);
      if (!(c * c > kLeastCorrelation * kLeastCorrelation * energy)) px128(v, u) = kMissing;
    }
  }
}

}  // namespace arpent::stereo
