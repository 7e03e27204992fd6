// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/elas/census.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace arpent::stereo {
namespace {

constexpr int kRadius = 2;
constexpr int kBitsPerPlane = 8;
constexpr int kPlanes = kCensusBits / kBitsPerPlane;

/// Shifts one comparison per pixel into `plane`. A plain loop over bytes: the compiler turns it into vector code on
/// every machine (bench `elas`).
void append_comparison(const std::uint8_t* neighbour, const std::uint8_t* centre, std::uint8_t* plane, int width) {
  for (int u = 0; u < width; ++u) {
    plane[u] = static_cast<std::uint8_t>((plane[u] << 1U) | (neighbour[u] >= centre[u] ? 1U : 0U));
  }
}

}  // namespace

void compute_census(const cv::Mat1b& image, cv::Mat1i& descriptors) {
  cv::Mat1b padded;
  cv::copyMakeBorder(image, padded, kRadius, kRadius, kRadius, kRadius, cv::BORDER_REPLICATE);
  descriptors.create(image.size());
  const int width = image.cols;
  std::array<std::vector<std::uint8_t>, kPlanes> planes;
  for (int v = 0; v < image.rows; ++v) {
    for (auto& plane : planes) plane.assign(static_cast<std::size_t>(width), 0);
    const std::uint8_t* centre = image.ptr(v);
    std::size_t bit = 0;
    for (int dv = 0; dv <= 2 * kRadius; ++dv) {
      for (int du = 0; du <= 2 * kRadius; ++du) {
        if (dv == kRadius && du == kRadius) continue;
        append_comparison(padded.ptr(v + dv) + du, centre, planes[bit++ / kBitsPerPlane].data(), width);
      }
    }
    int* out = descriptors[v];
    for (int u = 0; u < width; ++u) {
      const auto i = static_cast<std::size_t>(u);
      out[u] = planes[0][i] | planes[1][i] << 8 | planes[2][i] << 16;
    }
  }
}

}  // namespace arpent::stereo
