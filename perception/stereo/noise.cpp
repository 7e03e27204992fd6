// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/noise.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace arpent::stereo {
namespace {

/// One pixel in so many along rows and columns is enough for a quantile.
constexpr int kStep = 3;
constexpr double kQuantile = 0.3;
/// |x| below which 30 % of a unit normal distribution lie.
constexpr double kNormalQuantile = 0.3853;
/// Response of the mask to white noise of deviation 1: sqrt(4 * 1 + 4 * 4 + 16).
constexpr double kMaskGain = 6.0;
constexpr int kLargestResponse = 16 * 255;

int response(const cv::Mat1b& image, int u, int v) {
  const auto row = [&](int dv) { return image(v + dv, u - 1) - 2 * image(v + dv, u) + image(v + dv, u + 1); };
  return row(-1) - 2 * row(0) + row(1);
}

}  // namespace

double estimate_noise(const cv::Mat1b& image) {
  std::array<int, kLargestResponse + 1> histogram{};
  int count = 0;
  for (int v = 1; v + 1 < image.rows; v += kStep) {
    for (int u = 1; u + 1 < image.cols; u += kStep) {
      ++histogram[static_cast<std::size_t>(std::abs(response(image, u, v)))];
      ++count;
    }
  }
  const double wanted = kQuantile * count;
  double below = 0;
  for (std::size_t i = 0; i < histogram.size(); ++i) {
    if (below + histogram[i] < wanted) {
      below += histogram[i];
      continue;
    }
    // Responses are whole numbers: bin i holds magnitudes from i - 1/2 to i + 1/2.
    const double within = (wanted - below) / histogram[i];
    const double magnitude = i == 0 ? 0.5 * within : static_cast<double>(i) - 0.5 + within;
    return magnitude / (kNormalQuantile * kMaskGain);
  }
  return 0;
}

}  // namespace arpent::stereo
