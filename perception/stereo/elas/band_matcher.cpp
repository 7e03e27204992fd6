// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/elas/band_matcher.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "common/parallel.h"
#include "perception/stereo/elas/census.h"
#include "perception/stereo/elas/lanes.h"
#include "perception/stereo/elas/smoothness.h"
#include "perception/stereo/elas/winner.h"

namespace arpent::stereo {
/// Everything that is kept from pair to pair, so that memory is touched for the first time only once.
struct BandMatcher::Workspace {
  cv::Mat1i left_census;
  cv::Mat1i right_census;
  cv::Mat1i right_reversed;  ///< rows mirrored and continued beyond the border: ascending disparity is ascending memory
  cv::Mat1b costs;           ///< 16 per pixel
  cv::Mat1b sums;            ///< 16 per pixel
  cv::Mat1b path;            ///< one row of the vertical path, 16 per pixel
};

namespace {

const Link kContiguous = make_link({0, kBandWidth}, {0, kBandWidth});
const Link kSplit = make_link({0, 2 * kBandWidth}, {0, 2 * kBandWidth});

template <class L>
class Aggregation {
 public:
  using Vector = typename L::Vector;

  Aggregation(const cv::Mat1b& image, const CandidateGrid& grid, const SmoothnessParams& smoothness)
      : image_(image), grid_(grid), step_(smoothness.step), jump_(make_jump_table(smoothness)) {}

  /// Costs of the rows of a block row and the sums of their two horizontal paths.
  void match_block_row(int block_row, BandMatcher::Workspace& s) const {
    const std::vector<Links> links = link_row(block_row);
    const int begin = block_row * kBlock;
    const int end = std::min(begin + kBlock, image_.rows);
    std::vector<std::uint8_t> backwards(2 * row_bytes());
    int v = begin;
    for (; v + 2 <= end; v += 2) match_rows<2>(v, links, s, backwards);
    if (v < end) match_rows<1>(v, links, s, backwards);
  }

  /// One row of a vertical path over columns [begin, end), coming from row `from` (-1: the path starts here).
  void add_vertical(int v, int from, int begin, int end, const std::uint8_t* costs, std::uint8_t* path,
                    std::uint8_t* sums) const {
    const Bands* here = grid_.row(v / kBlock);
    const Bands* before = grid_.row((from < 0 ? v : from) / kBlock);
    for (int block = begin / kBlock; block * kBlock < end; ++block) {
      const Link link = make_link_fast(before[block], here[block]);
      for (int u = std::max(begin, block * kBlock); u < std::min(end, (block + 1) * kBlock); ++u) {
        const int jump = from < 0 ? 0 : jump_between(image_(v, u), image_(from, u));
        Vector next = from < 0 ? L::fill(255) : L::load(path + kLanes * u);
        const Vector here_costs = L::step(next, link, L::load(costs + kLanes * u), step_, jump, next);
        L::store(path + kLanes * u, next);
        L::store(sums + kLanes * u, L::add(L::load(sums + kLanes * u), here_costs));
      }
    }
  }

 private:
  struct Links {
    Link within;
    Link from_left;
    Link from_right;
  };
  struct Row {
    const std::uint8_t* grey;
    std::uint8_t* costs;
    std::uint8_t* sums;
    std::uint8_t* backwards;
  };

  [[nodiscard]] std::size_t row_bytes() const { return static_cast<std::size_t>(image_.cols) * kLanes; }

  /// `kRows` rows from `v` on. All their paths advance in one loop: independent chains hide each other's latency (bench
  /// `elas`).
  template <std::size_t kRows>
  void match_rows(int v, const std::vector<Links>& links, BandMatcher::Workspace& s,
                  std::vector<std::uint8_t>& backwards) const {
    const int cols = image_.cols;
    std::array<Row, kRows> row;
    for (std::size_t r = 0; r < kRows; ++r) {
      const int y = v + static_cast<int>(r);
      row[r] = {image_.ptr(y), s.costs[y], s.sums[y], backwards.data() + r * row_bytes()};
      compute_costs(y, s.left_census[y], s.right_reversed[y], row[r].costs);
    }
    Vector forth[kRows];  // NOLINT(modernize-avoid-c-arrays): std::array drops the attributes of a vector type
    Vector back[kRows];   // NOLINT(modernize-avoid-c-arrays)
    std::fill_n(forth, kRows, L::fill(255));
    std::fill_n(back, kRows, L::fill(255));
    for (int u = 0; u < cols; ++u) {
      const int w = cols - 1 - u;
      const Links& at_u = links[static_cast<std::size_t>(u / kBlock)];
      const Links& at_w = links[static_cast<std::size_t>(w / kBlock)];
      const Link& link_u = u % kBlock == 0 ? at_u.from_left : at_u.within;
      const Link& link_w = w % kBlock == kBlock - 1 ? at_w.from_right : at_w.within;
      const int u_before = std::max(u - 1, 0);
      const int w_before = std::min(w + 1, cols - 1);
      for (std::size_t r = 0; r < kRows; ++r) {
        const Row& here = row[r];
        const int jump_u = jump_between(here.grey[u], here.grey[u_before]);
        const int jump_w = jump_between(here.grey[w], here.grey[w_before]);
        L::store(here.sums + kLanes * u,
                 L::step(forth[r], link_u, L::load(here.costs + kLanes * u), step_, jump_u, forth[r]));
        L::store(here.backwards + kLanes * w,
                 L::step(back[r], link_w, L::load(here.costs + kLanes * w), step_, jump_w, back[r]));
      }
    }
    for (const Row& here : row) {
      for (int i = 0; i < cols * kLanes; i += kLanes) {
        L::store(here.sums + i, L::add(L::load(here.sums + i), L::load(here.backwards + i)));
      }
    }
  }

  [[nodiscard]] int jump_between(std::uint8_t a, std::uint8_t b) const {
    return jump_[static_cast<std::size_t>(std::abs(int{a} - int{b}))];
  }

  /// Most neighbours have the same bands, and then there are only two different links.
  [[nodiscard]] static Link make_link_fast(const Bands& from, const Bands& to) {
    if (from == to) return to.high == to.low + kBandWidth ? kContiguous : kSplit;
    return make_link(from, to);
  }

  [[nodiscard]] std::vector<Links> link_row(int block_row) const {
    const Bands* bands = grid_.row(block_row);
    std::vector<Links> links(static_cast<std::size_t>(grid_.cols));
    for (int b = 0; b < grid_.cols; ++b) {
      links[static_cast<std::size_t>(b)] = {make_link_fast(bands[b], bands[b]),
                                            make_link_fast(bands[std::max(b - 1, 0)], bands[b]),
                                            make_link_fast(bands[std::min(b + 1, grid_.cols - 1)], bands[b])};
    }
    return links;
  }

  void compute_costs(int v, const int* left, const int* right_reversed, std::uint8_t* costs) const {
    const Bands* bands = grid_.row(v / kBlock);
    const int cols = image_.cols;
    for (int u = 0; u < cols; ++u) {
      const Bands& b = bands[u / kBlock];
      const int* origin = right_reversed + cols - 1 - u;
      L::store(costs + kLanes * u, L::distances(left[u], origin + b.low, origin + b.high));
      if (b.high + kBandWidth - 1 <= u) continue;
      for (int lane = 0; lane < kLanes; ++lane) {
        if (b.disparity(lane) > u) costs[kLanes * u + lane] = kOutOfViewCost;
      }
    }
  }

  const cv::Mat1b& image_;
  const CandidateGrid& grid_;
  int step_;
  JumpTable jump_;
};

/// Continues the mirrored rows by what the largest candidate can reach.
void reverse_rows(const cv::Mat1i& census, int reach, cv::Mat1i& reversed) {
  reversed.create(census.rows, census.cols + reach);
  for (int v = 0; v < census.rows; ++v) {
    std::reverse_copy(census[v], census[v] + census.cols, reversed[v]);
    std::fill(reversed[v] + census.cols, reversed[v] + reversed.cols, census(v, 0));
  }
}

}  // namespace

BandMatcher::BandMatcher(const BandMatcherParams& params)
    : params_(params), workspace_(std::make_unique<Workspace>()) {}

BandMatcher::~BandMatcher() = default;

namespace {

template <class L, class Workspace>
void run(const BandMatcherParams& params, Workspace& s, const cv::Mat1b& left, const CandidateGrid& grid,
         LevelMatch& match) {
  const Aggregation<L> aggregation(left, grid, params.smoothness);
  const int rows = left.rows;
  const int cols = left.cols;
  s.costs.create(rows, cols * kLanes);
  s.sums.create(rows, cols * kLanes);
  s.path.create(1, cols * kLanes);
  match.px128.create(left.size());
  match.sharpness.create(left.size());

  const auto across = [&](int block_row) { aggregation.match_block_row(block_row, s); };
  const auto down = [&](int v, int begin, int end) {
    aggregation.add_vertical(v, v - 1, begin, end, s.costs[v], s.path[0], s.sums[v]);
  };
  const auto up = [&](int v, int begin, int end) {
    aggregation.add_vertical(v, v + 1 < rows ? v + 1 : -1, begin, end, s.costs[v], s.path[0], s.sums[v]);
  };
  const auto choose = [&](int v) {
    choose_winners<L>(s.sums[v], grid.row(v / kBlock), cols, match.px128[v], match.sharpness[v]);
  };

  if (params.threads == 1) {
    // Row after row, so that a row is still in the cache when the next stage takes it (bench `elas`).
    for (int block_row = 0; block_row < grid.rows; ++block_row) {
      across(block_row);
      for (int v = block_row * kBlock; v < std::min((block_row + 1) * kBlock, rows); ++v) down(v, 0, cols);
    }
    for (int v = rows - 1; v >= 0; --v) {
      up(v, 0, cols);
      choose(v);
    }
    return;
  }
  // The same stages, whole image by whole image: rows are independent of each other in two of them, columns in two.
  parallel_for(params.threads, grid.rows, [&](int begin, int end) {
    for (int block_row = begin; block_row < end; ++block_row) across(block_row);
  });
  parallel_for(params.threads, cols, [&](int begin, int end) {
    for (int v = 0; v < rows; ++v) down(v, begin, end);
    for (int v = rows - 1; v >= 0; --v) up(v, begin, end);
  });
  parallel_for(params.threads, rows, [&](int begin, int end) {
    for (int v = begin; v < end; ++v) choose(v);
  });
}

}  // namespace

void BandMatcher::match(const cv::Mat1b& left, const cv::Mat1b& right, const CandidateGrid& candidates,
                        LevelMatch& match) {
  Workspace& s = *workspace_;
  int reach = 0;
  for (const Bands& b : candidates.bands) reach = std::max(reach, b.high + kBandWidth);
  compute_census(left, s.left_census);
  compute_census(right, s.right_census);
  reverse_rows(s.right_census, reach, s.right_reversed);
  if (params_.portable) {
    run<PortableLanes>(params_, s, left, candidates, match);
  } else {
    run<NativeLanes>(params_, s, left, candidates, match);
  }
}

}  // namespace arpent::stereo
