// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/m3c2.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tools/evaluation/surface_index.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector3d;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The direction of least spread of the points within `radius_m`; oriented like `hint` if that is not zero. Zero with
/// fewer than 6 points.
Vector3d fit_normal(const Samples& samples, const PointGrid& grid, const Vector3d& p, double radius_m,
                    const Vector3d& hint) {
  Vector3d mean = Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
  double n = 0;
  grid.around(p, [&](int i) {
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
double mean_along(const Samples& samples, const PointGrid& grid, const Vector3d& p, const Vector3d& normal,
                  double radius_m, double depth_m) {
  double sum = 0;
  int n = 0;
  grid.around(p, [&](int i) {
    const Vector3d d = samples.points_m[static_cast<std::size_t>(i)] - p;
    const double along = d.dot(normal);
    if (std::abs(along) > depth_m || (d - along * normal).squaredNorm() > radius_m * radius_m) return;
    sum += along;
    ++n;
  });
  return n < 3 ? kNone : sum / n;
}

}  // namespace

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

std::vector<double> m3c2(const Samples& reference, const std::vector<std::size_t>& core, const Samples& estimate,
                         const M3c2Params& params) {
  const double edge_m = std::max(params.normal_radius_m, std::hypot(params.radius_m, params.half_length_m));
  const PointGrid reference_grid(reference.points_m, edge_m), estimate_grid(estimate.points_m, edge_m);
  std::vector<double> errors_m;
  errors_m.reserve(core.size());
  for (const std::size_t i : core) {
    const Vector3d& p = reference.points_m[i];
    const Vector3d normal = fit_normal(reference, reference_grid, p, params.normal_radius_m, reference.normals[i]);
    const auto mean = [&](const Samples& samples, const PointGrid& grid) {
      return mean_along(samples, grid, p, normal, params.radius_m, params.half_length_m);
    };
    errors_m.push_back(normal.isZero() ? kNone : mean(estimate, estimate_grid) - mean(reference, reference_grid));
  }
  return errors_m;
}

SignedErrors summarise(const std::vector<double>& errors_m) {
  SignedErrors result;
  double sum = 0, squares = 0;
  for (const double e : errors_m) {
    if (std::isnan(e)) continue;
    sum += 100 * e;
    squares += 1e4 * e * e;
    ++result.points;
  }
  if (result.points == 0) return result;
  result.mean_cm = sum / result.points;
  result.rmse_cm = std::sqrt(squares / result.points);
  result.std_cm = std::sqrt(std::max(0.0, squares / result.points - result.mean_cm * result.mean_cm));
  return result;
}

}  // namespace arpent::evaluation
