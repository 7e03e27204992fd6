// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/mesh.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <unordered_map>

#include "common/error.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector3d;
using Cell = Eigen::Vector3i;

struct CellHash {
  std::size_t operator()(const Cell& c) const {
    return static_cast<std::size_t>(c.x()) * 73856093U ^ static_cast<std::size_t>(c.y()) * 19349663U ^
           static_cast<std::size_t>(c.z()) * 83492791U;
  }
};

/// Buckets of a regular grid: what lies within one cell's edge of a point is in the 27 cells around it.
class Grid {
 public:
  explicit Grid(double edge_m) : edge_m_(edge_m) {}

  [[nodiscard]] Cell cell(const Vector3d& p) const { return (p / edge_m_).array().floor().cast<int>(); }
  void add(const Cell& c, int index) { cells_[c].push_back(index); }
  void add_box(const Vector3d& low, const Vector3d& high, int index) {
    const Cell a = cell(low), b = cell(high);
    for (int z = a.z(); z <= b.z(); ++z) {
      for (int y = a.y(); y <= b.y(); ++y) {
        for (int x = a.x(); x <= b.x(); ++x) add({x, y, z}, index);
      }
    }
  }
  template <class Visit>
  void around(const Vector3d& p, int reach, const Visit& visit) const {
    const Cell centre = cell(p);
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const auto found = cells_.find(centre + Cell(x, y, z));
          if (found == cells_.end()) continue;
          for (const int index : found->second) visit(index);
        }
      }
    }
  }

 private:
  double edge_m_;
  std::unordered_map<Cell, std::vector<int>, CellHash> cells_;
};

/// Nearest distance to a mesh or cloud, exact up to `limit_m`.
class Surface {
 public:
  Surface(const TriangleMesh& mesh, double limit_m) : mesh_(mesh), limit_m_(limit_m), grid_(limit_m) {
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      const auto [a, b, c] = corners(i);
      grid_.add_box(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), static_cast<int>(i));
    }
    for (std::size_t i = 0; mesh.triangles.empty() && i < mesh.vertices_m.size(); ++i) {
      grid_.add(grid_.cell(mesh.vertices_m[i].cast<double>()), static_cast<int>(i));
    }
  }

  /// `limit_m` if there is nothing within it.
  [[nodiscard]] double distance(const Vector3d& p) const {
    double nearest = limit_m_;
    grid_.around(p, 1, [&](int index) {
      const auto i = static_cast<std::size_t>(index);
      if (mesh_.triangles.empty()) {
        nearest = std::min(nearest, (mesh_.vertices_m[i].cast<double>() - p).norm());
      } else {
        const auto [a, b, c] = corners(i);
        nearest = std::min(nearest, point_triangle_distance(p, a, b, c));
      }
    });
    return nearest;
  }

 private:
  [[nodiscard]] std::array<Vector3d, 3> corners(std::size_t i) const {
    const auto& t = mesh_.triangles[i];
    return {mesh_.vertices_m[t[0]].cast<double>(), mesh_.vertices_m[t[1]].cast<double>(),
            mesh_.vertices_m[t[2]].cast<double>()};
  }

  const TriangleMesh& mesh_;
  double limit_m_;
  Grid grid_;
};

Grid bucket(const Samples& samples, double edge_m) {
  Grid grid(edge_m);
  for (std::size_t i = 0; i < samples.points_m.size(); ++i)
    grid.add(grid.cell(samples.points_m[i]), static_cast<int>(i));
  return grid;
}

/// The direction of least spread of the points within `radius_m`; oriented like `hint` if that is not zero. Zero with
/// fewer than 6 points.
Vector3d fit_normal(const Samples& samples, const Grid& grid, const Vector3d& p, double radius_m,
                    const Vector3d& hint) {
  Vector3d mean = Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double n = 0;
  grid.around(p, 1, [&](int i) {
    const Vector3d d = samples.points_m[static_cast<std::size_t>(i)] - p;
    if (d.squaredNorm() > radius_m * radius_m) return;
    mean += d;
    squares += d * d.transpose();
    ++n;
  });
  if (n < 6) return Vector3d::Zero();
  mean /= n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(squares / n - mean * mean.transpose());
  const Vector3d normal = solver.eigenvectors().col(0);
  return normal.dot(hint) < 0 ? Vector3d(-normal) : normal;
}

/// Mean position along `normal` of the samples in the cylinder around p; NaN with fewer than 3.
double mean_along(const Samples& samples, const Grid& grid, const Vector3d& p, const Vector3d& normal, double radius_m,
                  double depth_m) {
  double sum = 0;
  int n = 0;
  grid.around(p, 1, [&](int i) {
    const Vector3d d = samples.points_m[static_cast<std::size_t>(i)] - p;
    const double along = d.dot(normal);
    if (std::abs(along) > depth_m || (d - along * normal).squaredNorm() > radius_m * radius_m) return;
    sum += along;
    ++n;
  });
  return n < 3 ? std::numeric_limits<double>::quiet_NaN() : sum / n;
}

void measure_m3c2(const Samples& reference, const std::vector<bool>& covered, const Samples& estimate,
                  const MeshParams& params, MeshErrors& errors) {
  const double normal_radius = 0.5 * (params.normal_scale_m > 0 ? params.normal_scale_m : 4 * params.e_max_m);
  const double radius = 0.5 * (params.projection_scale_m > 0 ? params.projection_scale_m : 2 * params.e_max_m);
  const double edge = std::max(normal_radius, std::hypot(radius, params.e_max_m));
  const Grid reference_grid = bucket(reference, edge), estimate_grid = bucket(estimate, edge);
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < reference.points_m.size(); ++i) {
    if (!covered[i]) continue;
    const Vector3d& p = reference.points_m[i];
    const Vector3d normal = fit_normal(reference, reference_grid, p, normal_radius, reference.normals[i]);
    if (normal.isZero()) continue;
    const double a = mean_along(reference, reference_grid, p, normal, radius, params.e_max_m);
    const double b = mean_along(estimate, estimate_grid, p, normal, radius, params.e_max_m);
    if (std::isnan(a) || std::isnan(b)) continue;
    sum += 100 * (b - a);
    squares += 1e4 * (b - a) * (b - a);
    ++errors.m3c2_points;
  }
  if (errors.m3c2_points == 0) return;
  errors.mean_cm = sum / errors.m3c2_points;
  errors.rmse_cm = std::sqrt(squares / errors.m3c2_points);
  errors.std_cm = std::sqrt(std::max(0.0, squares / errors.m3c2_points - errors.mean_cm * errors.mean_cm));
}

}  // namespace

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

Samples sample_surface(const TriangleMesh& mesh, double per_m2, int max_samples, std::uint64_t seed) {
  Samples samples;
  if (mesh.triangles.empty()) {
    for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
      samples.points_m.push_back(mesh.vertices_m[i].cast<double>());
      samples.normals.push_back(mesh.normals.empty() ? Vector3d::Zero() : Vector3d(mesh.normals[i].cast<double>()));
    }
    return samples;
  }
  std::vector<double> area{0};
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f n = (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]);
    area.push_back(area.back() + 0.5 * static_cast<double>(n.norm()));
  }
  const int count = static_cast<int>(std::clamp(area.back() * per_m2, 1000.0, static_cast<double>(max_samples)));
  std::mt19937_64 generator(seed);
  const auto uniform = [&generator] { return static_cast<double>(generator() >> 11) * 0x1.0p-53; };
  for (int i = 0; i < count; ++i) {
    // Stratified along the cumulated area, uniform inside the triangle.
    const double at = (i + uniform()) / count * area.back();
    const auto found = std::upper_bound(area.begin(), area.end(), at) - area.begin() - 1;
    const auto& t = mesh.triangles[std::min(static_cast<std::size_t>(found), mesh.triangles.size() - 1)];
    const Vector3d a = mesh.vertices_m[t[0]].cast<double>(), b = mesh.vertices_m[t[1]].cast<double>(),
                   c = mesh.vertices_m[t[2]].cast<double>();
    const double r = std::sqrt(uniform()), s = uniform();
    samples.points_m.push_back((1 - r) * a + r * (1 - s) * b + r * s * c);
    samples.normals.push_back((b - a).cross(c - a).normalized());
  }
  return samples;
}

MeshErrors evaluate_mesh(const TriangleMesh& reference, const TriangleMesh& estimate, const MeshParams& params) {
  if (reference.vertices_m.empty()) throw InputError("the reference has no points");
  if (estimate.vertices_m.empty()) throw InputError("the estimate has no points");
  const Samples truth = sample_surface(reference, params.samples_per_m2, params.max_samples, params.seed);
  const Samples found = sample_surface(estimate, params.samples_per_m2, params.max_samples, params.seed + 1);
  MeshErrors errors;
  errors.reference_samples = static_cast<int>(truth.points_m.size());
  const Surface estimate_surface(estimate, params.e_max_m);
  std::vector<bool> covered;
  for (const Vector3d& p : truth.points_m) covered.push_back(estimate_surface.distance(p) < params.e_max_m);
  errors.coverage_percent = 100.0 * static_cast<double>(std::count(covered.begin(), covered.end(), true)) /
                            static_cast<double>(covered.size());
  const Surface reference_surface(reference, 4 * params.e_max_m);
  double squares = 0, trimmed = 0;
  int within = 0;
  for (const Vector3d& p : found.points_m) {
    const double d = 100 * reference_surface.distance(p);
    squares += d * d;
    if (d >= 100 * params.e_max_m) continue;
    trimmed += d * d;
    ++within;
  }
  const auto all = static_cast<double>(found.points_m.size());
  errors.accuracy_rmse_cm = std::sqrt(squares / all);
  errors.accuracy_trim_cm = within > 0 ? std::sqrt(trimmed / within) : 0;
  errors.beyond_percent = 100.0 * (all - within) / all;
  measure_m3c2(truth, covered, found, params, errors);
  return errors;
}

}  // namespace arpent::evaluation
