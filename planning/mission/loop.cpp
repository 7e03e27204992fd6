// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/loop.h"

#include <cmath>
#include <numbers>

#include "common/error.h"

namespace arpent::planning {
namespace {

using Eigen::Vector2d;

constexpr double kSpacingM = 0.05;
constexpr double kOnSideM = 1e-6;

class Points {
 public:
  void start(const Vector2d& p) { points_.push_back(p); }
  void line_to(const Vector2d& end) {
    const Vector2d begin = points_.back();
    const int steps = std::max(1, static_cast<int>(std::ceil((end - begin).norm() / kSpacingM)));
    for (int i = 1; i <= steps; ++i) points_.push_back(begin + (end - begin) * (static_cast<double>(i) / steps));
  }
  /// A quarter turn to the left around `centre`, from the direction `from_rad` as seen from there.
  void corner(const Vector2d& centre, double radius_m, double from_rad) {
    const double quarter = std::numbers::pi / 2;
    const int steps = std::max(4, static_cast<int>(std::ceil(quarter * radius_m / kSpacingM)));
    for (int i = 1; i <= steps; ++i) {
      const double angle = from_rad + quarter * i / steps;
      points_.push_back(centre + radius_m * Vector2d(std::cos(angle), std::sin(angle)));
    }
  }
  /// A cubic Bezier curve that leaves towards the end and arrives along `heading`.
  void curve_to(const Vector2d& end, const Vector2d& heading) {
    const Vector2d begin = points_.back();
    const double third = (end - begin).norm() / 3;
    const Vector2d a = begin + (end - begin) / 3;
    const Vector2d b = end - third * heading;
    const int steps = std::max(2, static_cast<int>(std::ceil(3 * third / kSpacingM)));
    for (int i = 1; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps;
      const double s = 1 - t;
      points_.emplace_back(s * s * s * begin + 3 * s * s * t * a + 3 * s * t * t * b + t * t * t * end);
    }
  }
  [[nodiscard]] std::vector<Vector2d> take() { return std::move(points_); }

 private:
  std::vector<Vector2d> points_;
};

}  // namespace

std::vector<Vector2d> make_loop(const Pose2& start, const LoopParams& params) {
  const Vector2d centre(params.centre_m[0], params.centre_m[1]);
  const Vector2d half = 0.5 * Vector2d(params.size_m[0], params.size_m[1]);
  const Vector2d entry(params.entry_m[0], params.entry_m[1]);
  const double r = params.corner_radius_m;
  if (half.minCoeff() < r) throw InputError("loop: corner_radius_m must fit twice into each side");
  const Vector2d inner = half - Vector2d(r, r);
  if (std::abs(entry.y() - (centre.y() - half.y())) > kOnSideM || std::abs(entry.x() - centre.x()) > inner.x()) {
    throw InputError("loop: entry_m must lie on the straight part of the lower side");
  }
  Points points;
  points.start(start.position_m());
  points.curve_to(entry, Vector2d::UnitX());
  const auto at = [&](double x, double y) -> Vector2d { return centre + Vector2d(x, y); };
  const double quarter = std::numbers::pi / 2;
  for (int lap = 0; lap < params.laps; ++lap) {
    points.line_to(at(inner.x(), -half.y()));
    points.corner(at(inner.x(), -inner.y()), r, -quarter);
    points.line_to(at(half.x(), inner.y()));
    points.corner(at(inner.x(), inner.y()), r, 0);
    points.line_to(at(-inner.x(), half.y()));
    points.corner(at(-inner.x(), inner.y()), r, quarter);
    points.line_to(at(-half.x(), -inner.y()));
    points.corner(at(-inner.x(), -inner.y()), r, 2 * quarter);
    points.line_to(entry);
  }
  return points.take();
}

}  // namespace arpent::planning
