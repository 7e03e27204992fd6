// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// One search from one place prices the drives to all others: Dijkstra's algorithm on the 16-connected grid of cells
// where the robot's centre may be, with costs that keep off obstacles. Lengths exceed the shortest by up to 2.7 % from
// the lattice's sixteen directions. The footprint's length is not looked at; the leg that is driven is (leg_planner.h).
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "planning/local/ground.h"

namespace arpent::planning {

class Sweep {
 public:
  /// Searches from `source_m` (or the nearest cell within 15 cm where the robot may be) as far as `max_cost_m`; ends
  /// early once the cell of `until_m` is reached and everything that costs up to `beyond_m` more. Cost: metres in the
  /// open, more near obstacles. `ground` must outlive the sweep. Whole numbers inside: exact, the same everywhere.
  explicit Sweep(const Ground& ground, const Eigen::Vector2d& source_m,
                 double max_cost_m = std::numeric_limits<double>::infinity(),
                 const std::optional<Eigen::Vector2d>& until_m = std::nullopt, double beyond_m = 0);

  /// nullopt where it did not reach.
  [[nodiscard]] std::optional<double> cost_m(const Eigen::Vector2d& p_m) const;
  /// Length of the cheapest way [m].
  [[nodiscard]] std::optional<double> length_m(const Eigen::Vector2d& p_m) const;
  /// The cheapest way from the source to `p_m`, cell by cell; empty if there is none.
  [[nodiscard]] std::vector<Eigen::Vector2d> way_to(const Eigen::Vector2d& p_m) const;

  /// Per cell of the ground's frame the cost in 1/1024 cells; kNotReached where there is none.
  [[nodiscard]] const std::vector<std::uint32_t>& costs() const { return costs_; }
  static constexpr std::uint32_t kNotReached = UINT32_MAX;
  static constexpr int kUnitsPerCell = 1024;

 private:
  void search(std::size_t source, std::uint32_t max_cost, std::optional<std::size_t> until, std::uint32_t beyond);
  [[nodiscard]] std::optional<std::size_t> reached_cell(const Eigen::Vector2d& p_m) const;

  const Ground& ground_;
  Eigen::Vector2d source_m_;
  std::vector<std::uint32_t> costs_;
  std::vector<std::uint8_t> from_;  ///< index of the step that led here
};

/// Length of the drive from one place to each of the others [m], in their order, as FreeSpace asks: nullopt where no
/// way leads, or it is longer than `max_m`. One sweep.
[[nodiscard]] std::vector<std::optional<double>> drive_lengths_m(
    const Ground& ground, const Pose2& from, std::span<const Pose2> to,
    double max_m = std::numeric_limits<double>::infinity());

/// Step from a cell to another, and its length in 1/1024 cells.
struct GridStep {
  int dx = 0;
  int dy = 0;
  int length = 0;
};
/// The sixteen steps of a sweep: sides, diagonals, knight's moves. The latter also need both cells between.
[[nodiscard]] std::span<const GridStep> grid_steps();

}  // namespace arpent::planning
