// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/distance_transform.h"

#include <algorithm>

#include "common/error.h"

namespace arpent::planning {
namespace {

constexpr int kMaxSide = 20000;

/// Distance to the nearest marked cell of the same column, `far` if there is none.
std::vector<std::int32_t> distances_along_columns(std::span<const std::uint8_t> marked, int cols, int rows,
                                                  std::int32_t far) {
  const auto width = static_cast<std::size_t>(cols);
  std::vector<std::int32_t> g(marked.size(), far);
  for (std::size_t at = 0; at < marked.size(); ++at) {
    const std::int32_t above = at < width ? far : g[at - width];
    g[at] = marked[at] != 0 ? 0 : std::min(far, above + 1);
  }
  for (std::size_t at = static_cast<std::size_t>(rows - 1) * width; at-- > 0;)
    g[at] = std::min(g[at], g[at + width] + 1);
  return g;
}

/// The lower envelope of the parabolas (x - u)^2 + g(u)^2 of one row.
class Envelope {
 public:
  explicit Envelope(int cols) : apex_(static_cast<std::size_t>(cols)), from_(static_cast<std::size_t>(cols)) {}

  void transform(const std::int32_t* g, int cols, std::int32_t far, std::int32_t* squared) {
    std::size_t count = 0;
    for (int u = 0; u < cols; ++u) {
      if (g[u] >= far) continue;
      while (count > 0 && value(g, from_[count - 1], apex_[count - 1]) > value(g, from_[count - 1], u)) --count;
      if (count == 0) {
        apex_[0] = u;
        from_[0] = 0;
        count = 1;
      } else if (const std::int64_t from = 1 + meet(g, apex_[count - 1], u); from < cols) {
        apex_[count] = u;
        from_[count++] = static_cast<std::int32_t>(from);
      }
    }
    for (int x = cols - 1; x >= 0; --x) {
      while (count > 1 && from_[count - 1] > x) --count;
      squared[x] = count == 0 ? kNoneMarked : static_cast<std::int32_t>(value(g, x, apex_[count - 1]));
    }
  }

 private:
  static std::int64_t value(const std::int32_t* g, std::int64_t x, std::int64_t u) {
    return (x - u) * (x - u) + static_cast<std::int64_t>(g[u]) * g[u];
  }
  /// Last x at which the parabola of `u` is at least as low as the one of `v` > u.
  static std::int64_t meet(const std::int32_t* g, std::int64_t u, std::int64_t v) {
    return (v * v - u * u + static_cast<std::int64_t>(g[v]) * g[v] - static_cast<std::int64_t>(g[u]) * g[u]) /
           (2 * (v - u));
  }

  std::vector<std::int32_t> apex_, from_;
};

}  // namespace

std::vector<std::int32_t> squared_distances(std::span<const std::uint8_t> marked, int cols, int rows) {
  ARPENT_ASSERT(cols > 0 && rows > 0 && cols <= kMaxSide && rows <= kMaxSide);
  ARPENT_ASSERT(marked.size() == static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows));
  const std::int32_t far = cols + rows;
  const auto g = distances_along_columns(marked, cols, rows, far);
  std::vector<std::int32_t> squared(marked.size());
  Envelope envelope(cols);
  for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
    const std::size_t at = row * static_cast<std::size_t>(cols);
    envelope.transform(&g[at], cols, far, &squared[at]);
  }
  return squared;
}

}  // namespace arpent::planning
