// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The path to be driven, by arc length: positions, headings, curvatures, and the speed that limits and the stop at its
// end allow everywhere.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "control/limits.h"

namespace arpent::control {

struct PathPoint {
  Eigen::Vector2d p_m = Eigen::Vector2d::Zero();
  double heading_rad = 0;    ///< of the tangent, continuous along the path (not wrapped)
  double curvature_1pm = 0;  ///< positive to the left
  double speed_mps = 0;      ///< greatest sensible speed
};

class Path {
 public:
  /// Through `points_m` (map frame) in straight pieces, driven forwards; corners are to be rounded by whoever plans.
  /// Throws InputError if fewer than two distinct points are given or one is not finite.
  Path(const std::vector<Eigen::Vector2d>& points_m, const Limits& limits);

  [[nodiscard]] double length_m() const { return length_m_; }
  /// Interpolated at arc length `s_m`, held to [0, length].
  [[nodiscard]] PathPoint at(double s_m) const;
  /// Arc length of the nearest point within [from, to].
  [[nodiscard]] double project(const Eigen::Vector2d& p_m, double from_m, double to_m) const;

 private:
  void resample(const std::vector<Eigen::Vector2d>& points_m);
  void differentiate();
  void limit_speed(const Limits& limits);

  double length_m_ = 0;
  double spacing_m_ = 0;
  std::vector<PathPoint> points_;
};

}  // namespace arpent::control
