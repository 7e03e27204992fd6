// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a robot on the ground can run into: the world's surfaces between two heights, seen from above. Exact for boxes,
// cylinders (as prisms), planes and mesh triangles; the inside of boxes and cylinders counts as solid.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/pose2.h"
#include "sim/world/world.h"

namespace arpent::sim {

/// An ellipse around the body's origin; the defaults are the thesis' collision semi-axes.
struct EllipseFootprint {
  double semi_long_m = 0.55;
  double semi_short_m = 0.25;
};

class GroundMap {
 public:
  using Polygon = std::vector<Eigen::Vector2d>;  ///< convex; may be flat (a wall)

  /// Surfaces below `low_m` can be driven over, those above `high_m` driven under.
  explicit GroundMap(const World& world, double low_m = 0.02, double high_m = 0.60);

  /// Does a robot at `pose` touch anything?
  [[nodiscard]] bool hits(const Pose2& pose, const EllipseFootprint& footprint) const;
  /// Distance to the nearest obstacle, 0 inside one; infinite in an empty world.
  [[nodiscard]] double distance_m(const Eigen::Vector2d& p_world_m) const;
  [[nodiscard]] const std::vector<Polygon>& obstacles() const { return obstacles_; }

 private:
  void add(Polygon polygon);
  void build_index();
  template <class Visit>
  void visit_cells(int column0, int row0, int column1, int row1, Visit visit) const;

  std::vector<Polygon> obstacles_;
  // A grid over the obstacles: which of them touch each cell.
  Eigen::Vector2d corner_m_ = Eigen::Vector2d::Zero();
  int columns_ = 0;
  int rows_ = 0;
  std::vector<std::vector<int>> cells_;
};

/// Do two robots touch?
[[nodiscard]] bool overlap(const Pose2& a, const EllipseFootprint& footprint_a, const Pose2& b,
                           const EllipseFootprint& footprint_b);

}  // namespace arpent::sim
