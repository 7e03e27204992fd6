// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where the cells of a grid on the ground lie in the map frame.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

namespace arpent::planning {

/// Cell (i, j) covers [(first + i) * cell_m, (first + i + 1) * cell_m) along x, and so on along y. Cells lie row by
/// row.
struct GridFrame {
  double cell_m = 0.05;
  Eigen::Vector2i first = Eigen::Vector2i::Zero();
  int cols = 0;
  int rows = 0;

  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(cols) * static_cast<std::size_t>(rows); }
  [[nodiscard]] std::size_t at(int i, int j) const {
    return static_cast<std::size_t>(j) * static_cast<std::size_t>(cols) + static_cast<std::size_t>(i);
  }
  [[nodiscard]] bool has(int i, int j) const { return i >= 0 && j >= 0 && i < cols && j < rows; }
  [[nodiscard]] Eigen::Vector2i cell_of(const Eigen::Vector2d& p_m) const {
    return (p_m / cell_m).array().floor().cast<int>().matrix() - first;
  }
  [[nodiscard]] Eigen::Vector2d centre_m(int i, int j) const {
    return {(first.x() + i + 0.5) * cell_m, (first.y() + j + 0.5) * cell_m};
  }
  [[nodiscard]] Eigen::Vector2d centre_m(std::size_t index) const {
    const auto width = static_cast<std::size_t>(cols);
    return centre_m(static_cast<int>(index % width), static_cast<int>(index / width));
  }
};

}  // namespace arpent::planning
