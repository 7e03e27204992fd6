// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/clip.h"

namespace arpent::sim {

Cut clip(const std::vector<Eigen::Vector3d>& polygon, const HalfSpace& half_space) {
  Cut cut;
  bool any_inside = false, any_outside = false;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector3d& p = polygon[i];
    const Eigen::Vector3d& q = polygon[(i + 1) % polygon.size()];
    const double a = half_space.normal.dot(p) - half_space.offset, b = half_space.normal.dot(q) - half_space.offset;
    if (a >= 0) cut.inside.push_back(p);
    if (a <= 0) cut.outside.push_back(p);
    any_inside = any_inside || a > 0;
    any_outside = any_outside || a < 0;
    if ((a > 0 && b < 0) || (a < 0 && b > 0)) {
      const Eigen::Vector3d crossing = p + a / (a - b) * (q - p);
      cut.inside.push_back(crossing);
      cut.outside.push_back(crossing);
    }
  }
  // A polygon within the plane itself counts as inside.
  if (!any_outside) return {polygon, {}};
  if (!any_inside) return {{}, polygon};
  return cut;
}

}  // namespace arpent::sim
