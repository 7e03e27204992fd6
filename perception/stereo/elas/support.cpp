// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/elas/support.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace arpent::stereo {
namespace {

constexpr int kCell = 5;
constexpr int kFar = 10;

struct Vertex {
  double u;
  double v;
  double px128;
};

using Triangle = std::array<Vertex, 3>;

/// The plane px128 = a u + b v + c through a triangle.
struct Plane {
  double a;
  double b;
  double c;
};

/// Twice the signed area.
double cross(const Triangle& t) {
  return (t[1].u - t[0].u) * (t[2].v - t[0].v) - (t[2].u - t[0].u) * (t[1].v - t[0].v);
}

Plane plane_through(const Triangle& t, double area) {
  const double d1 = t[1].px128 - t[0].px128;
  const double d2 = t[2].px128 - t[0].px128;
  const double a = (d1 * (t[2].v - t[0].v) - d2 * (t[1].v - t[0].v)) / area;
  const double b = (d2 * (t[1].u - t[0].u) - d1 * (t[2].u - t[0].u)) / area;
  return {a, b, t[0].px128 - a * t[0].u - b * t[0].v};
}

/// Part of the row `v` that lies inside the triangle, both ends included; empty if first > last.
std::pair<int, int> span_at(const Triangle& t, int v) {
  double first = 1e9;
  double last = -1e9;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vertex& p = t[i];
    const Vertex& q = t[(i + 1) % 3];
    if (std::min(p.v, q.v) > v || std::max(p.v, q.v) < v) continue;
    const double u = p.v == q.v ? q.u : p.u + (q.u - p.u) * (v - p.v) / (q.v - p.v);
    first = std::min(first, u);
    last = std::max(last, u);
  }
  constexpr double kRounding = 1e-9;
  return {static_cast<int>(std::ceil(first - kRounding)), static_cast<int>(std::floor(last + kRounding))};
}

void draw(const Triangle& t, cv::Mat1w& prior) {
  const double area = cross(t);
  if (area == 0) return;
  const Plane plane = plane_through(t, area);
  const auto [top, bottom] = std::minmax({t[0].v, t[1].v, t[2].v});
  for (int v = static_cast<int>(top); v <= static_cast<int>(bottom); ++v) {
    const auto [first, last] = span_at(t, v);
    for (int u = first; u <= last; ++u) {
      prior(v, u) = static_cast<std::uint16_t>(std::max(plane.a * u + plane.b * v + plane.c + 0.5, 0.0));
    }
  }
}

}  // namespace

std::vector<SupportPoint> select_support_points(const LevelMatch& match) {
  std::vector<SupportPoint> points;
  for (int v0 = 0; v0 < match.px128.rows; v0 += kCell) {
    for (int u0 = 0; u0 < match.px128.cols; u0 += kCell) {
      int sharpest = 0;
      SupportPoint best{};
      for (int v = v0; v < std::min(v0 + kCell, match.px128.rows); ++v) {
        for (int u = u0; u < std::min(u0 + kCell, match.px128.cols); ++u) {
          if (match.px128(v, u) == kMissing || match.sharpness(v, u) <= sharpest) continue;
          sharpest = match.sharpness(v, u);
          best = {u, v, match.px128(v, u)};
        }
      }
      if (sharpest > 0) points.push_back(best);
    }
  }
  return points;
}

cv::Mat1w interpolate_prior(const std::vector<SupportPoint>& points, const cv::Size& size) {
  cv::Mat1w prior(size, kMissing);
  if (points.size() < 3) return prior;
  cv::Mat1w known(size, kMissing);
  std::vector<cv::Point2f> positions;
  positions.reserve(points.size());
  for (const SupportPoint& p : points) {
    known(p.v, p.u) = p.px128;
    positions.emplace_back(static_cast<float>(p.u), static_cast<float>(p.v));
  }
  // OpenCV starts from three vertices that lie three sizes of this area away, and takes them for real: near ones would
  // cut slivers off the convex hull.
  const cv::Rect area(-kFar * size.width, -kFar * size.height, (2 * kFar + 1) * size.width,
                      (2 * kFar + 1) * size.height);
  cv::Subdiv2D subdivision(area);
  subdivision.insert(positions);
  std::vector<cv::Vec6f> corners;
  subdivision.getTriangleList(corners);
  const cv::Rect image({0, 0}, size);
  for (const cv::Vec6f& c : corners) {
    Triangle triangle{};
    bool inside = true;
    for (int i = 0; i < 3; ++i) {
      // OpenCV also returns triangles with its own three far-away vertices.
      const cv::Point p(static_cast<int>(c[2 * i]), static_cast<int>(c[2 * i + 1]));
      inside = inside && image.contains(p);
      if (inside) triangle[static_cast<std::size_t>(i)] = {double(p.x), double(p.y), double(known(p))};
    }
    if (inside) draw(triangle, prior);
  }
  return prior;
}

}  // namespace arpent::stereo
