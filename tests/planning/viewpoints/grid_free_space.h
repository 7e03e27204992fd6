// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Free space on a grid of squares, for tests and benches: a robot that is a point, Dijkstra over eight neighbours.
#pragma once

#include <cmath>
#include <functional>
#include <queue>
#include <vector>

#include "planning/viewpoints/free_space.h"

namespace arpent::planning {

class GridFreeSpace : public FreeSpace {
 public:
  /// Squares of edge `cell_m` whose centres lie in [least, most]; `free` is asked once about each centre.
  GridFreeSpace(const Eigen::Vector2d& least_m, const Eigen::Vector2d& most_m, double cell_m,
                const std::function<bool(const Eigen::Vector2d&)>& free)
      : least_m_(least_m),
        cell_m_(cell_m),
        cols_(static_cast<int>((most_m.x() - least_m.x()) / cell_m) + 1),
        rows_(static_cast<int>((most_m.y() - least_m.y()) / cell_m) + 1) {
    for (int y = 0; y < rows_; ++y) {
      for (int x = 0; x < cols_; ++x) free_.push_back(free(least_m + cell_m * Eigen::Vector2d(x, y)) ? 1 : 0);
    }
  }

  [[nodiscard]] bool is_free(const Pose2& pose) const override {
    const int cell = cell_of(pose);
    return cell >= 0 && free_[static_cast<std::size_t>(cell)] != 0;
  }

  [[nodiscard]] std::vector<std::optional<double>> distances_m(const Pose2& from, std::span<const Pose2> to,
                                                               double max_m) const override {
    const std::vector<double> reached_m = search(from, max_m);
    std::vector<std::optional<double>> distances;
    for (const Pose2& pose : to) {
      const int cell = cell_of(pose);
      const double d = cell < 0 ? kFar : reached_m[static_cast<std::size_t>(cell)];
      distances.push_back(d <= max_m && d < kFar ? std::optional(d) : std::nullopt);
    }
    return distances;
  }

 private:
  static constexpr double kFar = 1e9;

  [[nodiscard]] int cell_of(const Pose2& pose) const {
    const auto x = static_cast<int>(std::lround((pose.x_m - least_m_.x()) / cell_m_));
    const auto y = static_cast<int>(std::lround((pose.y_m - least_m_.y()) / cell_m_));
    return x < 0 || y < 0 || x >= cols_ || y >= rows_ ? -1 : x + cols_ * y;
  }

  [[nodiscard]] std::vector<double> search(const Pose2& from, double max_m) const {
    std::vector<double> reached_m(free_.size(), kFar);
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    if (is_free(from)) queue.emplace(0.0, cell_of(from));
    while (!queue.empty()) {
      const auto [d, cell] = queue.top();
      queue.pop();
      if (d > max_m || d >= reached_m[static_cast<std::size_t>(cell)]) continue;
      reached_m[static_cast<std::size_t>(cell)] = d;
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = cell % cols_ + dx, y = cell / cols_ + dy;
          if (x < 0 || y < 0 || x >= cols_ || y >= rows_) continue;
          const int next = x + cols_ * y;
          if (free_[static_cast<std::size_t>(next)] != 0) queue.emplace(d + cell_m_ * std::hypot(dx, dy), next);
        }
      }
    }
    return reached_m;
  }

  Eigen::Vector2d least_m_;
  double cell_m_;
  int cols_, rows_;
  std::vector<std::uint8_t> free_;
};

}  // namespace arpent::planning
