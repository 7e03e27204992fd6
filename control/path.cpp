// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/path.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/error.h"
#include "common/pose2.h"

namespace arpent::control {
namespace {

constexpr double kSpacingM = 0.02;
/// Headings and curvatures are differences over this length to each side.
constexpr double kSmoothingM = 0.06;
/// Turn rate and acceleration that the reference uses; the rest is left to correct errors with.
constexpr double kShareOfLimits = 0.9;

}  // namespace

Path::Path(const std::vector<Eigen::Vector2d>& points_m, const Limits& limits) {
  if (!std::all_of(points_m.begin(), points_m.end(), [](const auto& p) { return p.allFinite(); })) {
    throw InputError("path: a point is not finite");
  }
  resample(points_m);
  differentiate();
  limit_speed(limits);
}

void Path::resample(const std::vector<Eigen::Vector2d>& points_m) {
  for (std::size_t i = 1; i < points_m.size(); ++i) length_m_ += (points_m[i] - points_m[i - 1]).norm();
  if (!(length_m_ > kSpacingM)) throw InputError("path: needs at least two points that are apart");
  const auto pieces = static_cast<std::size_t>(std::ceil(length_m_ / kSpacingM));
  spacing_m_ = length_m_ / static_cast<double>(pieces);
  double begin = 0;
  std::size_t k = 0;
  double piece = (points_m[1] - points_m[0]).norm();
  for (std::size_t i = 0; i <= pieces; ++i) {
    const double s = spacing_m_ * static_cast<double>(i);
    while (s > begin + piece && k + 2 < points_m.size()) {
      begin += piece;
      ++k;
      piece = (points_m[k + 1] - points_m[k]).norm();
    }
    const double t = piece > 0 ? std::clamp((s - begin) / piece, 0.0, 1.0) : 0.0;
    PathPoint point;
    point.p_m = points_m[k] + t * (points_m[k + 1] - points_m[k]);
    points_.push_back(point);
  }
}

void Path::differentiate() {
  const auto count = static_cast<int>(points_.size());
  const int reach = std::max(1, static_cast<int>(std::lround(kSmoothingM / spacing_m_)));
  const auto at = [&](int i) -> PathPoint& { return points_[static_cast<std::size_t>(std::clamp(i, 0, count - 1))]; };
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d d = at(i + reach).p_m - at(i - reach).p_m;
    const double heading = std::atan2(d.y(), d.x());
    at(i).heading_rad = i == 0 ? heading : at(i - 1).heading_rad + wrap_angle(heading - at(i - 1).heading_rad);
  }
  for (int i = 0; i < count; ++i) {
    const int before = std::max(i - reach, 0), after = std::min(i + reach, count - 1);
    at(i).curvature_1pm = (at(after).heading_rad - at(before).heading_rad) / (spacing_m_ * (after - before));
  }
}

void Path::limit_speed(const Limits& limits) {
  for (PathPoint& p : points_) {
    const double turning = kShareOfLimits * limits.max_turn_rate_radps / std::max(std::abs(p.curvature_1pm), 1e-6);
    p.speed_mps = std::min(limits.max_speed_mps, turning);
  }
  points_.back().speed_mps = 0;
  const double twice = 2 * kShareOfLimits * limits.max_acceleration_mps2 * spacing_m_;
  for (std::size_t i = points_.size() - 1; i-- > 0;) {
    const double next = points_[i + 1].speed_mps;
    points_[i].speed_mps = std::min(points_[i].speed_mps, std::sqrt(next * next + twice));
  }
}

PathPoint Path::at(double s_m) const {
  const double x = std::clamp(s_m, 0.0, length_m_) / spacing_m_;
  const std::size_t i = std::min(static_cast<std::size_t>(x), points_.size() - 2);
  const double t = std::min(x - static_cast<double>(i), 1.0);
  const PathPoint& a = points_[i];
  const PathPoint& b = points_[i + 1];
  const auto mix = [t](double from, double to) { return from + t * (to - from); };
  return {a.p_m + t * (b.p_m - a.p_m), mix(a.heading_rad, b.heading_rad), mix(a.curvature_1pm, b.curvature_1pm),
          mix(a.speed_mps, b.speed_mps)};
}

double Path::project(const Eigen::Vector2d& p_m, double from_m, double to_m) const {
  const auto first = static_cast<std::size_t>(std::clamp(from_m, 0.0, length_m_) / spacing_m_);
  const std::size_t last =
      std::min(static_cast<std::size_t>(std::clamp(to_m, 0.0, length_m_) / spacing_m_) + 1, points_.size() - 1);
  double nearest = std::numeric_limits<double>::infinity();
  double s = 0;
  for (std::size_t i = std::min(first, points_.size() - 2); i < last; ++i) {
    const Eigen::Vector2d along = points_[i + 1].p_m - points_[i].p_m;
    const double t = std::clamp((p_m - points_[i].p_m).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
    const double distance = (points_[i].p_m + t * along - p_m).squaredNorm();
    if (distance >= nearest) continue;
    nearest = distance;
    s = (static_cast<double>(i) + t) * spacing_m_;
  }
  return s;
}

}  // namespace arpent::control
