// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which poses of a body on the ground of a true world are connected with its start: a lattice in (x, y, heading),
// flooded over free poses. A body that turns and drives gets everywhere within a connected free space, so neighbours in
// any of the three directions count as connected.
#pragma once

#include <vector>

#include "sim/world/ground.h"
#include "sim/world/world.h"

namespace arpent::evaluation {

class Reach {
 public:
  /// Bodies' origins stay inside the region. `headings` of the lattice, `step_m` in x and y.
  Reach(const sim::World& world, const Pose2& start, const sim::EllipseFootprint& footprint, double step_m,
        int headings);

  /// Whether the body is free there, and the nearest pose of the lattice is connected with the start.
  [[nodiscard]] bool contains(const Pose2& body) const;

 private:
  struct Node {
    int column, row, heading;
  };
  [[nodiscard]] Pose2 pose(const Node& node) const;
  [[nodiscard]] bool in_lattice(const Node& node) const;
  [[nodiscard]] std::size_t index(const Node& node) const;
  [[nodiscard]] Node nearest(const Pose2& body) const;
  [[nodiscard]] bool is_free(const Node& node);
  void flood(const Pose2& start);

  sim::GroundMap ground_;
  sim::Region region_;
  sim::EllipseFootprint footprint_;
  double step_m_;
  int headings_, columns_, rows_;
  std::vector<std::uint8_t> reached_;
  std::vector<float> clearance_m_;  ///< of each place, as far as it was asked for; negative: not yet
};

}  // namespace arpent::evaluation
