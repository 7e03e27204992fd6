// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/sweep.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/error.h"

namespace arpent::planning {
namespace {

constexpr std::array<GridStep, 16> kSteps = {{{1, 0, 1024},
                                              {-1, 0, 1024},
                                              {0, 1, 1024},
                                              {0, -1, 1024},
                                              {1, 1, 1448},
                                              {-1, 1, 1448},
                                              {1, -1, 1448},
                                              {-1, -1, 1448},
                                              {2, 1, 2290},
                                              {-2, 1, 2290},
                                              {2, -1, 2290},
                                              {-2, -1, 2290},
                                              {1, 2, 2290},
                                              {-1, 2, 2290},
                                              {1, -2, 2290},
                                              {-1, -2, 2290}}};
constexpr std::size_t kFirstKnight = 8;
constexpr std::uint8_t kSource = 0xFF;
constexpr int kSnapCells = 3;
/// The mean of two weights times a length, weights in 1/64.
constexpr int kMeanShift = 7;

/// Where each step leads in the array, and the two cells that a knight's move crosses.
struct Offsets {
  std::ptrdiff_t to = 0;
  std::ptrdiff_t between[2] = {0, 0};
  std::uint32_t length = 0;
};

std::array<Offsets, 16> offsets_of(const GridFrame& frame) {
  std::array<Offsets, 16> offsets;
  const std::ptrdiff_t row = frame.cols;
  for (std::size_t k = 0; k < kSteps.size(); ++k) {
    const GridStep& step = kSteps[k];
    offsets[k].to = step.dx + step.dy * row;
    offsets[k].length = static_cast<std::uint32_t>(step.length);
    if (k < kFirstKnight) continue;
    const int sx = step.dx > 0 ? 1 : -1, sy = step.dy > 0 ? 1 : -1;
    offsets[k].between[0] = std::abs(step.dx) == 2 ? sx : sy * row;
    offsets[k].between[1] = sx + sy * row;
  }
  return offsets;
}

struct Entry {
  std::uint32_t cell;
  std::uint32_t cost;
};

/// A ring of buckets as wide as the cheapest step: what lies in the lowest one is final, in whatever order it is taken
/// (Denardo and Fox, "Shortest-route methods: 1. Reaching, pruning, and buckets", 1979).
class BucketQueue {
 public:
  explicit BucketQueue(std::uint32_t dearest_step) {
    std::size_t count = 2;
    while (count < dearest_step / Sweep::kUnitsPerCell + 2) count *= 2;
    buckets_.resize(count);
  }
  void push(Entry entry) {
    buckets_[entry.cost / Sweep::kUnitsPerCell & (buckets_.size() - 1)].push_back(entry);
    ++waiting_;
  }
  /// All of the lowest bucket; empty if there are none left.
  [[nodiscard]] std::vector<Entry> take() {
    if (waiting_ == 0) return {};
    while (buckets_[lowest_ & (buckets_.size() - 1)].empty()) ++lowest_;
    std::vector<Entry> taken;
    taken.swap(buckets_[lowest_ & (buckets_.size() - 1)]);
    waiting_ -= taken.size();
    return taken;
  }

 private:
  std::vector<std::vector<Entry>> buckets_;
  std::size_t lowest_ = 0;
  std::size_t waiting_ = 0;
};

/// The nearest cell around where `allowed`; ties by the scan's order.
template <class Allowed>
std::optional<std::size_t> snap(const GridFrame& frame, const Eigen::Vector2d& p_m, const Allowed& allowed) {
  const Eigen::Vector2i cell = frame.cell_of(p_m);
  std::optional<std::size_t> nearest;
  double least = std::numeric_limits<double>::infinity();
  for (int j = cell.y() - kSnapCells; j <= cell.y() + kSnapCells; ++j) {
    for (int i = cell.x() - kSnapCells; i <= cell.x() + kSnapCells; ++i) {
      if (!frame.has(i, j) || !allowed(frame.at(i, j))) continue;
      const double d = (frame.centre_m(i, j) - p_m).squaredNorm();
      if (d >= least) continue;
      least = d;
      nearest = frame.at(i, j);
    }
  }
  return nearest;
}

std::uint32_t in_units(double metres, double cell_m) {
  return static_cast<std::uint32_t>(std::min(metres / cell_m * Sweep::kUnitsPerCell, 4.0e9));
}

}  // namespace

std::span<const GridStep> grid_steps() {
  return kSteps;
}

Sweep::Sweep(const Ground& ground, const Eigen::Vector2d& source_m, double max_cost_m,
             const std::optional<Eigen::Vector2d>& until_m, double beyond_m)
    : ground_(ground), source_m_(source_m) {
  const GridFrame& frame = ground.frame();
  costs_.assign(frame.size(), kNotReached);
  from_.assign(frame.size(), kSource);
  if (!source_m.allFinite()) return;
  const auto drivable = [&](std::size_t at) { return ground.weights()[at] != 0; };
  const auto source = snap(frame, source_m, drivable);
  if (!source) return;
  const auto until = until_m ? snap(frame, *until_m, drivable) : std::nullopt;
  search(*source, in_units(max_cost_m, frame.cell_m), until, in_units(beyond_m, frame.cell_m));
}

void Sweep::search(std::size_t source, std::uint32_t max_cost, std::optional<std::size_t> until, std::uint32_t beyond) {
  const std::vector<std::uint16_t>& weights = ground_.weights();
  const auto offsets = offsets_of(ground_.frame());
  const std::uint32_t dearest_weight = *std::max_element(weights.begin(), weights.end());
  BucketQueue queue(kSteps.back().length * 2 * dearest_weight >> kMeanShift);
  costs_[source] = 0;
  queue.push({static_cast<std::uint32_t>(source), 0});
  for (std::vector<Entry> bucket = queue.take(); !bucket.empty(); bucket = queue.take()) {
    if (until && costs_[*until] < bucket.front().cost) {
      max_cost = std::min(max_cost, costs_[*until] + beyond);
      until.reset();
    }
    for (const Entry& entry : bucket) {
      const std::size_t here = entry.cell;
      if (costs_[here] != entry.cost) continue;
      const std::uint32_t weight = weights[here];
      for (std::size_t k = 0; k < offsets.size(); ++k) {
        const Offsets& step = offsets[k];
        const std::size_t to = here + static_cast<std::size_t>(step.to);
        const std::uint32_t there = weights[to];
        if (there == 0) continue;
        const std::uint32_t cost = entry.cost + (step.length * (weight + there) >> kMeanShift);
        if (cost >= costs_[to] || cost > max_cost) continue;
        if (k >= kFirstKnight && (weights[here + static_cast<std::size_t>(step.between[0])] == 0 ||
                                  weights[here + static_cast<std::size_t>(step.between[1])] == 0)) {
          continue;
        }
        costs_[to] = cost;
        from_[to] = static_cast<std::uint8_t>(k);
        queue.push({static_cast<std::uint32_t>(to), cost});
      }
    }
  }
}

std::optional<std::size_t> Sweep::reached_cell(const Eigen::Vector2d& p_m) const {
  if (!p_m.allFinite()) return std::nullopt;
  return snap(ground_.frame(), p_m, [&](std::size_t at) { return costs_[at] != kNotReached; });
}

std::optional<double> Sweep::cost_m(const Eigen::Vector2d& p_m) const {
  const auto cell = reached_cell(p_m);
  if (!cell) return std::nullopt;
  return static_cast<double>(costs_[*cell]) / kUnitsPerCell * ground_.frame().cell_m;
}

std::optional<double> Sweep::length_m(const Eigen::Vector2d& p_m) const {
  const auto cell = reached_cell(p_m);
  if (!cell) return std::nullopt;
  std::uint64_t units = 0;
  std::size_t at = *cell;
  while (from_[at] != kSource) {
    const GridStep& step = kSteps[from_[at]];
    units += static_cast<std::uint64_t>(step.length);
    at -= static_cast<std::size_t>(step.dx + step.dy * static_cast<std::ptrdiff_t>(ground_.frame().cols));
  }
  // The straight line is the least that it can be; where the lattice says less, both ends were snapped towards each
  // other.
  return std::max(static_cast<double>(units) / kUnitsPerCell * ground_.frame().cell_m, (p_m - source_m_).norm());
}

std::vector<Eigen::Vector2d> Sweep::way_to(const Eigen::Vector2d& p_m) const {
  const auto cell = reached_cell(p_m);
  if (!cell) return {};
  std::vector<Eigen::Vector2d> way = {ground_.frame().centre_m(*cell)};
  std::size_t at = *cell;
  while (from_[at] != kSource) {
    const GridStep& step = kSteps[from_[at]];
    at -= static_cast<std::size_t>(step.dx + step.dy * static_cast<std::ptrdiff_t>(ground_.frame().cols));
    way.push_back(ground_.frame().centre_m(at));
  }
  std::reverse(way.begin(), way.end());
  return way;
}

std::vector<std::optional<double>> drive_lengths_m(const Ground& ground, const Pose2& from, std::span<const Pose2> to,
                                                   double max_m) {
  std::uint16_t dearest = kWeightOne;
  for (const std::uint16_t weight : ground.weights()) dearest = std::max(dearest, weight);
  // A way of this length costs at most so much; the cell where it ends may be one beside.
  const double max_cost_m = max_m * dearest / kWeightOne + ground.frame().cell_m;
  const Sweep sweep(ground, from.position_m(), max_cost_m);
  std::vector<std::optional<double>> lengths_m;
  lengths_m.reserve(to.size());
  for (const Pose2& pose : to) {
    auto length_m = sweep.length_m(pose.position_m());
    if (length_m && *length_m > max_m) length_m.reset();
    lengths_m.push_back(length_m);
  }
  return lengths_m;
}

}  // namespace arpent::planning
