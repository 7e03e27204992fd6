// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The ground for one footprint at one moment: how far every place is from what is not known to be free, whether the
// robot may stand or move there, and what a drive costs. A snapshot: it does not change when the map does.
#pragma once

#include <optional>
#include <vector>

#include "planning/local/footprint.h"
#include "planning/local/ground_grid.h"
#include "planning/local/motion.h"

namespace arpent::planning {

/// What a path costs, in metres driven in the open.
struct DriveCosts {
  double comfort_m = 0.7;
  double clearance_weight = 2.0;
  double turn_m_per_rad = 0.3;
  double stop_m = 0.25;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("comfort_m", self.comfort_m, "nearer to obstacles than this, seen from the body's origin, costs more",
                  config::between(0.1, 5.0));
    visitor.field("clearance_weight", self.clearance_weight, "what it costs more at an obstacle, per metre",
                  config::between(0.0, 10.0));
    visitor.field("turn_m_per_rad", self.turn_m_per_rad, "cost of a turn on the spot, per radian",
                  config::at_least(0.0));
    visitor.field("stop_m", self.stop_m, "cost of stopping to turn on the spot", config::at_least(0.0));
  }
};

class Ground {
 public:
  /// Takes a few milliseconds for 100 000 cells (bench `planning`). Throws InputError for costs that break their rules.
  Ground(const GroundGrid& grid, const Footprint& footprint, const DriveCosts& costs = {});
  /// From cells given directly; the two outermost rings must be unknown.
  Ground(const GridFrame& frame, std::vector<CellState> states, const Footprint& footprint,
         const DriveCosts& costs = {});

  [[nodiscard]] const GridFrame& frame() const { return frame_; }
  [[nodiscard]] const Footprint& footprint() const { return footprint_; }
  [[nodiscard]] const DriveCosts& costs() const { return costs_; }
  [[nodiscard]] CellState state(const Eigen::Vector2d& p_m) const;

  /// Distance to the edge of the nearest cell that is not free, interpolated; 0 there and beyond the grid. Too great by
  /// at most a fifth of a cell (at corners of cells), too small by at most one and a half.
  [[nodiscard]] double clearance_m(const Eigen::Vector2d& p_m) const;
  /// How much the footprint may grow at this pose before it touches what is not free; negative if it does already.
  [[nodiscard]] double margin_m(const Pose2& pose) const;
  [[nodiscard]] bool is_free(const Pose2& pose) const { return margin_m(pose) >= 0; }
  /// Share of the motion at which the footprint first reaches deeper than `slack_m` into what is not free; nullopt if
  /// it never does. Advances by the room there is, so nothing is stepped over. Turns of almost half a circle must be
  /// free both ways round.
  [[nodiscard]] std::optional<double> first_contact(const Motion& motion, double slack_m = 0) const;
  /// Cost of a motion that is free; the first of a row pays for the stop, if it is a turn.
  [[nodiscard]] double cost_of(const Motion& motion) const;
  [[nodiscard]] double cost_of(const Motions& motions) const;

  /// Per cell the cost of driving one metre there, in 1/64; 0 where the robot's centre cannot be.
  [[nodiscard]] const std::vector<std::uint16_t>& weights() const { return weights_; }

 private:
  void weigh();
  [[nodiscard]] double weight_at(double clearance_m) const;

  GridFrame frame_;
  std::vector<CellState> states_;
  Footprint footprint_;
  DriveCosts costs_;
  std::vector<float> clearance_m_;
  std::vector<std::uint16_t> weights_;
};

inline constexpr int kWeightOne = 64;

}  // namespace arpent::planning
