// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/surface_index.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace arpent::evaluation {

using Eigen::Vector3d;

SurfaceIndex::SurfaceIndex(const TriangleMesh& mesh, double limit_m) : mesh_(mesh), limit_m_(limit_m), grid_(limit_m) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = corners(i);
    grid_.add_box(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), static_cast<int>(i));
  }
  for (std::size_t i = 0; mesh.triangles.empty() && i < mesh.vertices_m.size(); ++i) {
    grid_.add(mesh.vertices_m[i].cast<double>(), static_cast<int>(i));
  }
}

double SurfaceIndex::distance_to(int index, const Vector3d& p) const {
  const auto i = static_cast<std::size_t>(index);
  if (mesh_.triangles.empty()) return (mesh_.vertices_m[i].cast<double>() - p).norm();
  const auto [a, b, c] = corners(i);
  return point_triangle_distance(p, a, b, c);
}

SurfaceIndex::Nearest SurfaceIndex::nearest(const Vector3d& p) const {
  Nearest best{limit_m_};
  grid_.around(p, [&](int index) {
    const double distance_m = distance_to(index, p);
    if (distance_m < best.distance_m) best = {distance_m, index};
  });
  return best;
}

bool SurfaceIndex::has_near(const Vector3d& p) const {
  return grid_.any_around(p, [&](int index) { return distance_to(index, p) < limit_m_; });
}

std::array<Vector3d, 3> SurfaceIndex::corners(std::size_t triangle) const {
  const auto& t = mesh_.triangles[triangle];
  return {mesh_.vertices_m[t[0]].cast<double>(), mesh_.vertices_m[t[1]].cast<double>(),
          mesh_.vertices_m[t[2]].cast<double>()};
}

double point_triangle_distance(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto to_edge = [&p](const Vector3d& u, const Vector3d& v) {
    const Vector3d e = v - u;
    const double length2 = e.squaredNorm();
    const double s = length2 > 0 ? std::clamp((p - u).dot(e) / length2, 0.0, 1.0) : 0.0;
    return (p - u - s * e).norm();
  };
  const Vector3d n = (b - a).cross(c - a);
  const double area2 = n.squaredNorm();
  if (area2 > 0) {
    const double wa = (c - b).cross(p - b).dot(n), wb = (a - c).cross(p - c).dot(n), wc = (b - a).cross(p - a).dot(n);
    if (wa >= 0 && wb >= 0 && wc >= 0) return std::abs((p - a).dot(n)) / std::sqrt(area2);
  }
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

}  // namespace arpent::evaluation
