// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/elas/coarse.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <utility>
#include <vector>

#include "perception/stereo/elas/census.h"
#include "perception/stereo/elas/winner.h"

namespace arpent::stereo {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// Path cost beyond both ends of the range: never the least, and far from overflow.
constexpr std::uint8_t kNever = 200;
/// Disparities are padded to whole vectors.
constexpr int kRangeMultiple = 16;

class WholeRange {
 public:
  WholeRange(const cv::Mat1b& left, const cv::Mat1b& right, int range, const SmoothnessParams& smoothness)
      : image_(left),
        lanes_((range + kRangeMultiple - 1) / kRangeMultiple * kRangeMultiple),
        range_(range),
        step_(smoothness.step),
        jump_(make_jump_table(smoothness)),
        costs_(size()),
        sums_(size(), 0) {
    compute_costs(right);
  }

  LevelMatch run() {
    for (const int forward : {1, -1}) {
      add_paths(forward, image_.cols, image_.rows, [](int along, int line) { return std::pair(along, line); });
      add_paths(forward, image_.rows, image_.cols, [](int along, int line) { return std::pair(line, along); });
    }
    LevelMatch match{cv::Mat1w(image_.size()), cv::Mat1b(image_.size())};
    for (int v = 0; v < image_.rows; ++v) choose_row(v, match);
    return match;
  }

 private:
  [[nodiscard]] std::size_t size() const { return index(0, image_.rows); }
  [[nodiscard]] std::size_t index(int u, int v) const {
    return (static_cast<std::size_t>(v) * static_cast<std::size_t>(image_.cols) + static_cast<std::size_t>(u)) *
           static_cast<std::size_t>(lanes_);
  }

  void compute_costs(const cv::Mat1b& right) {
    cv::Mat1i a;
    cv::Mat1i b;
    compute_census(image_, a);
    compute_census(right, b);
    for (int v = 0; v < image_.rows; ++v) {
      for (int u = 0; u < image_.cols; ++u) {
        std::uint8_t* out = costs_.data() + index(u, v);
        const int in_view = std::min(u + 1, lanes_);
        for (int d = 0; d < in_view; ++d) {
          out[d] = static_cast<std::uint8_t>(std::popcount(static_cast<std::uint32_t>(a(v, u) ^ b(v, u - d))));
        }
        std::fill(out + in_view, out + lanes_, kOutOfViewCost);
      }
    }
  }

  /// All paths of one direction: `lines` of them, each over `length` pixels; `at` maps (along, line) to (u, v).
  template <class At>
  void add_paths(int forward, int length, int lines, const At& at) {
    Bytes buffer(static_cast<std::size_t>(lanes_) + 2, kNever);
    std::uint8_t* path = buffer.data() + 1;
    Bytes next(static_cast<std::size_t>(lanes_));
    for (int line = 0; line < lines; ++line) {
      std::fill_n(path, lanes_, std::uint8_t{0});
      int before = -1;
      for (int i = 0; i < length; ++i) {
        const auto [u, v] = at(forward > 0 ? i : length - 1 - i, line);
        const int grey = image_(v, u);
        const int jump = before < 0 ? 0 : jump_[static_cast<std::size_t>(std::abs(grey - before))];
        before = grey;
        step(path, next.data(), costs_.data() + index(u, v), sums_.data() + index(u, v), jump);
      }
    }
  }

  /// `path` holds the path costs of the pixel before minus their least, and is replaced by this pixel's.
  void step(std::uint8_t* path, std::uint8_t* next, const std::uint8_t* costs, std::uint8_t* sums, int jump) const {
    const auto step_cost = static_cast<std::uint8_t>(step_);
    const auto jump_cost = static_cast<std::uint8_t>(jump);
    std::uint8_t least = 255;
    for (int d = 0; d < lanes_; ++d) {
      const std::uint8_t beside = std::min(path[d - 1], path[d + 1]);
      const auto stepped = static_cast<std::uint8_t>(beside + step_cost);
      const auto value = static_cast<std::uint8_t>(costs[d] + std::min(std::min(path[d], stepped), jump_cost));
      next[d] = value;
      sums[d] = static_cast<std::uint8_t>(sums[d] + value);
      least = std::min(least, value);
    }
    for (int d = 0; d < lanes_; ++d) path[d] = static_cast<std::uint8_t>(next[d] - least);
  }

  static bool has_rival(const std::uint8_t* sums, int count, int disparity_px) {
    const int limit = rival_limit(sums[disparity_px]);
    const auto below = [limit](std::uint8_t sum) { return sum < limit; };
    const auto* beside = sums + std::max(disparity_px - 1, 0);
    const auto* beyond = sums + std::min(disparity_px + 2, count);
    return std::any_of(sums, beside, below) || std::any_of(beyond, sums + count, below);
  }

  void choose_row(int v, LevelMatch& match) const {
    Winners winners(image_.cols);
    for (int u = 0; u < image_.cols; ++u) {
      const std::uint8_t* sums = sums_.data() + index(u, v);
      const int in_view = std::min(u + 1, range_);
      const auto d = static_cast<int>(std::min_element(sums, sums + in_view) - sums);
      const int beside = d > 0 && d + 1 < range_ ? 1 : 0;
      winners.set(u, d, sums[d], sums[d - beside], sums[d + beside], has_rival(sums, in_view, d));
    }
    settle_row(winners, match.px128[v], match.sharpness[v]);
  }

  const cv::Mat1b& image_;
  int lanes_;
  int range_;
  int step_;
  JumpTable jump_;
  Bytes costs_;
  Bytes sums_;
};

}  // namespace

LevelMatch match_whole_range(const cv::Mat1b& left, const cv::Mat1b& right, int range_px,
                             const SmoothnessParams& smoothness) {
  return WholeRange(left, right, range_px, smoothness).run();
}

}  // namespace arpent::stereo
