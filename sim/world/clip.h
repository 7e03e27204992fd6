// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Cutting flat convex polygons with planes.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace arpent::sim {

/// The points with normal . p >= offset.
struct HalfSpace {
  Eigen::Vector3d normal;
  double offset = 0;
};

struct Cut {
  std::vector<Eigen::Vector3d> inside;
  std::vector<Eigen::Vector3d> outside;
};

/// Both parts of a polygon, each empty if it has no area (or, of a polygon without area, no length).
[[nodiscard]] Cut clip(const std::vector<Eigen::Vector3d>& polygon, const HalfSpace& half_space);

}  // namespace arpent::sim
