// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/reject.h"

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "perception/stereo/depth_map.h"

namespace arpent::stereo {
namespace {

constexpr int kCells = 11;  // of 2 x 2 pixels: the window's edge
constexpr int kDifferenceReach = 2;
/// Noise matched to noise correlates by less than this, texture as strong as the noise by more.
constexpr float kLeastCorrelation = 0.45F;
constexpr int kUnitsPerWholePixel = 128;
constexpr int kUnitsPerHalfPixel = 64;

/// Pixels of a row from `begin` to before `end`, each within a pixel of disparity of the one before.
struct Run {
  int begin;
  int end;
  int parent;  // a run of the same piece, lower in number; itself at the root
  int pixels;  // of the whole piece, at the root
};

bool are_joined(std::uint16_t a, std::uint16_t b) {
  return std::abs(int{a} - int{b}) <= kUnitsPerPixel;
}

int find_root(std::vector<Run>& runs, int run) {
  while (runs[run].parent != run) run = runs[run].parent = runs[runs[run].parent].parent;
  return run;
}

void unite(std::vector<Run>& runs, int a, int b) {
  a = find_root(runs, a);
  b = find_root(runs, b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  runs[b].parent = a;
  runs[a].pixels += runs[b].pixels;
}

void add_runs(const std::uint16_t* row, int cols, std::vector<Run>& runs) {
  for (int u = 0; u < cols;) {
    if (row[u] == kMissing) {
      ++u;
      continue;
    }
    const int begin = u++;
    while (u < cols && row[u] != kMissing && are_joined(row[u - 1], row[u])) ++u;
    runs.push_back({begin, u, static_cast<int>(runs.size()), u - begin});
  }
}

/// Joins the runs from `first` on, of `row`, with those of the row above, from `first_above` to `first`.
void join_rows(const std::uint16_t* above, const std::uint16_t* row, int first_above, int first,
               std::vector<Run>& runs) {
  int a = first_above;
  int b = first;
  while (a < first && b < static_cast<int>(runs.size())) {
    const int end = std::min(runs[a].end, runs[b].end);
    for (int u = std::max(runs[a].begin, runs[b].begin); u < end; ++u) {
      if (!are_joined(above[u], row[u])) continue;
      unite(runs, a, b);
      break;
    }
    runs[a].end <= runs[b].end ? ++a : ++b;
  }
}

}  // namespace

void remove_speckles(cv::Mat1w& px128, int largest_pixels) {
  std::vector<Run> runs;
  std::vector<int> first_of_row{0};
  for (int v = 0; v < px128.rows; ++v) {
    add_runs(px128[v], px128.cols, runs);
    if (v > 0) join_rows(px128[v - 1], px128[v], first_of_row[v - 1], first_of_row[v], runs);
    first_of_row.push_back(static_cast<int>(runs.size()));
  }
  for (int v = 0; v < px128.rows; ++v) {
    for (int i = first_of_row[v]; i < first_of_row[v + 1]; ++i) {
      if (runs[find_root(runs, i)].pixels > largest_pixels) continue;
      std::fill(px128[v] + runs[i].begin, px128[v] + runs[i].end, kMissing);
    }
  }
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
