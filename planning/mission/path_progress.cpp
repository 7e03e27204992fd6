// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/path_progress.h"

namespace arpent::planning {

double length_m(const std::vector<Eigen::Vector2d>& points_m) {
  double sum = 0;
  for (std::size_t i = 1; i < points_m.size(); ++i) sum += (points_m[i] - points_m[i - 1]).norm();
  return sum;
}

std::vector<Eigen::Vector2d> rest_of(const std::vector<Eigen::Vector2d>& points_m, double driven_m,
                                     const Eigen::Vector2d& from_m) {
  std::vector<Eigen::Vector2d> rest{from_m};
  double s = 0;
  for (std::size_t i = 0; i < points_m.size(); ++i) {
    if (i > 0) s += (points_m[i] - points_m[i - 1]).norm();
    if (s >= driven_m && points_m[i] != from_m) rest.push_back(points_m[i]);
  }
  return rest;
}

}  // namespace arpent::planning
