// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/fill.h"

#include <algorithm>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {
namespace {

/// False if the row has no value at all. kMissing is the largest number, so the smaller of both ends is the known or
/// the farther one.
bool fill_row(std::uint16_t* row, int width) {
  std::uint16_t before = kMissing;
  for (int u = 0; u < width;) {
    if (row[u] != kMissing) {
      before = row[u++];
      continue;
    }
    const int end = static_cast<int>(std::find_if(row + u, row + width, [](auto d) { return d != kMissing; }) - row);
    const std::uint16_t value = std::min(before, end < width ? row[end] : kMissing);
    if (value == kMissing) return false;
    std::fill(row + u, row + end, value);
    u = end;
  }
  return true;
}

}  // namespace

void fill_from_background(cv::Mat1w& px128) {
  cv::Mat1b known(px128.rows, 1);
  for (int v = 0; v < px128.rows; ++v) known(v) = fill_row(px128.ptr<std::uint16_t>(v), px128.cols) ? 1 : 0;
  for (int v = 1; v < px128.rows; ++v) {
    if (known(v) != 0 || known(v - 1) == 0) continue;
    px128.row(v - 1).copyTo(px128.row(v));
    known(v) = 1;
  }
  for (int v = px128.rows - 2; v >= 0; --v) {
    if (known(v) != 0 || known(v + 1) == 0) continue;
    px128.row(v + 1).copyTo(px128.row(v));
    known(v) = 1;
  }
}

}  // namespace arpent::stereo
