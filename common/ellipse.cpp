// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/ellipse.h"

#include <cmath>
#include <numbers>

namespace arpent {

bool ellipses_overlap(double semi_long_m, double semi_short_m, const Pose2& a, const Pose2& b) {
  // Where `a` is the unit circle, b is an ellipse: the nearest of its points to the origin decides.
  const Pose2 b_in_a = to_pose2(a.to_pose().inverse() * b.to_pose());
  if (b_in_a.position_m().norm() > 2 * semi_long_m) return false;
  const double c = std::cos(b_in_a.yaw_rad), s = std::sin(b_in_a.yaw_rad);
  const auto squared = [&](double t) {
    const double u = semi_long_m * std::cos(t), v = semi_short_m * std::sin(t);
    const double x = (b_in_a.x_m + c * u - s * v) / semi_long_m, y = (b_in_a.y_m + s * u + c * v) / semi_short_m;
    return x * x + y * y;
  };
  constexpr int kSteps = 360;
  int best = 0;
  for (int i = 1; i < kSteps; ++i) {
    if (squared(i * 2 * std::numbers::pi / kSteps) < squared(best * 2 * std::numbers::pi / kSteps)) best = i;
  }
  double low = (best - 1) * 2 * std::numbers::pi / kSteps, high = (best + 1) * 2 * std::numbers::pi / kSteps;
  for (int i = 0; i < 40; ++i) {
    const double p = low + (high - low) / 3, q = high - (high - low) / 3;
    (squared(p) < squared(q) ? high : low) = squared(p) < squared(q) ? q : p;
  }
  // The centre of `a` within b: no boundary point need be near.
  const double u = -c * b_in_a.x_m - s * b_in_a.y_m, v = s * b_in_a.x_m - c * b_in_a.y_m;
  const bool inside = std::hypot(u / semi_long_m, v / semi_short_m) <= 1;
  return inside || squared(0.5 * (low + high)) <= 1;
}

}  // namespace arpent
