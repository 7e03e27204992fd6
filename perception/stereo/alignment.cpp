// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <vector>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {
namespace {

constexpr int kHalfWindow = 4;
constexpr int kMaxOffset = 3;
constexpr int kGrid = 16;
constexpr int kMinVerticalGradient = 300;  // sum over the window: 81 pixels with about 4 grey levels each
constexpr std::size_t kMinSamples = 50;
constexpr int kMargin = kHalfWindow + kMaxOffset + 1;

int vertical_gradient(const cv::Mat1b& image, int u, int v) {
  int sum = 0;
  for (int dv = -kHalfWindow; dv <= kHalfWindow; ++dv) {
    for (int du = -kHalfWindow; du <= kHalfWindow; ++du) {
      sum += std::abs(int{image(v + dv + 1, u + du)} - int{image(v + dv - 1, u + du)});
    }
  }
  return sum;
}

/// Squared differences of the windows around (u, v) and (u_right, v + offset), with their means taken out.
double dissimilarity(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int u_right, int offset) {
  constexpr int kCount = (2 * kHalfWindow + 1) * (2 * kHalfWindow + 1);
  std::int64_t sum = 0;
  std::int64_t squares = 0;
  for (int dv = -kHalfWindow; dv <= kHalfWindow; ++dv) {
    for (int du = -kHalfWindow; du <= kHalfWindow; ++du) {
      const int d = int{left(v + dv, u + du)} - int{right(v + dv + offset, u_right + du)};
      sum += d;
      squares += d * d;
    }
  }
  return static_cast<double>(squares) - static_cast<double>(sum * sum) / kCount;
}

/// The offset with the least dissimilarity, refined by a parabola; nullopt if it lies at the border of the search. The
/// disparity may be off by what a vertical offset did to it, so columns one to each side are searched as well.
std::optional<double> offset_at(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int u_right) {
  std::array<double, 2 * kMaxOffset + 1> cost{};
  for (int offset = -kMaxOffset; offset <= kMaxOffset; ++offset) {
    double& best = cost[static_cast<std::size_t>(offset + kMaxOffset)];
    best = std::numeric_limits<double>::max();
    for (int du = -1; du <= 1; ++du) best = std::min(best, dissimilarity(left, right, u, v, u_right + du, offset));
  }
  const auto least = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  if (least == 0 || least + 1 == cost.size()) return std::nullopt;
  const double curvature = cost[least - 1] - 2 * cost[least] + cost[least + 1];
  if (curvature <= 0) return std::nullopt;
  return static_cast<double>(least) - kMaxOffset + 0.5 * (cost[least - 1] - cost[least + 1]) / curvature;
}

}  // namespace

double measure_vertical_offset_px(const cv::Mat1b& left, const cv::Mat1b& right, const cv::Mat1w& px128) {
  std::vector<double> offsets;
  for (int v = kMargin; v < left.rows - kMargin; v += kGrid) {
    for (int u = kMargin; u < left.cols - kMargin; u += kGrid) {
      if (px128(v, u) == kMissing || vertical_gradient(left, u, v) < kMinVerticalGradient) continue;
      const int u_right = u - static_cast<int>(std::lround(px128(v, u) / kUnitsPerPixel));
      if (u_right < kMargin || u_right >= right.cols - kMargin) continue;
      if (const auto offset = offset_at(left, right, u, v, u_right)) offsets.push_back(*offset);
    }
  }
  if (offsets.size() < kMinSamples) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2);
  std::nth_element(offsets.begin(), middle, offsets.end());
  return *middle;
}

}  // namespace arpent::stereo
