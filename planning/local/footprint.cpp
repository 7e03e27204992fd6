// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/local/footprint.h"

#include <algorithm>
#include <cmath>

#include "common/config/config.h"
#include "common/error.h"

namespace arpent::planning {
namespace {

/// Distance of two discs' centres, as a share of the short axis: the discs' radius grows with it.
constexpr double kSpacing = 0.4;
constexpr int kBoundarySamples = 4000;

}  // namespace

Footprint::Footprint(const FootprintParams& params) : params_(params) {
  config::check(params, "footprint");
  const double a = params.semi_axis_long_m, b = params.semi_axis_short_m;
  if (a < b) throw InputError("footprint: semi_axis_long_m must be at least semi_axis_short_m");
  // The last disc is the ellipse's circle of curvature at its end.
  const double reach = a - b * b / a;
  const int each_side = static_cast<int>(std::ceil(reach / (kSpacing * b)));
  for (int i = -each_side; i <= each_side; ++i) {
    discs_.push_back({each_side > 0 ? reach * i / each_side : 0.0, 0.0});
  }
  for (int i = 0; i <= kBoundarySamples; ++i) {
    const double t = std::numbers::pi * i / kBoundarySamples;
    const Eigen::Vector2d p(a * std::cos(t), b * std::sin(t));
    auto& nearest = *std::min_element(discs_.begin(), discs_.end(), [&](const auto& one, const auto& other) {
      // The largest disc inside of the ellipse that touches it at p has its centre here.
      const double centre = p.x() * reach / a;
      return std::abs(one.along_m - centre) < std::abs(other.along_m - centre);
    });
    nearest.radius_m = std::max(nearest.radius_m, (p - Eigen::Vector2d(nearest.along_m, 0)).norm());
  }
  // Between two of the samples the boundary stands out by no more than a hair.
  for (FootprintDisc& disc : discs_) disc.radius_m += 2e-3 * b;
}

bool Footprint::contains(const Pose2& pose, const Eigen::Vector2d& p_m, double margin_m) const {
  const Eigen::Vector2d d = p_m - pose.position_m();
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const double along = (c * d.x() + s * d.y()) / (params_.semi_axis_long_m + margin_m);
  const double across = (c * d.y() - s * d.x()) / (params_.semi_axis_short_m + margin_m);
  return along * along + across * across <= 1;
}

}  // namespace arpent::planning
