// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/mesh.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "tools/evaluation/surface_index.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector3d;

void measure_m3c2(const Samples& reference, const std::vector<bool>& covered, const Samples& estimate,
                  const MeshParams& params, MeshErrors& errors) {
  M3c2Params m3c2_params;
  m3c2_params.normal_radius_m = 0.5 * (params.normal_scale_m > 0 ? params.normal_scale_m : 4 * params.e_max_m);
  m3c2_params.radius_m = 0.5 * (params.projection_scale_m > 0 ? params.projection_scale_m : 2 * params.e_max_m);
  m3c2_params.half_length_m = params.e_max_m;
  std::vector<std::size_t> core;
  for (std::size_t i = 0; i < covered.size(); ++i) {
    if (covered[i]) core.push_back(i);
  }
  const SignedErrors signed_errors = summarise(m3c2(reference, core, estimate, m3c2_params));
  errors.m3c2_points = signed_errors.points;
  errors.mean_cm = signed_errors.mean_cm;
  errors.std_cm = signed_errors.std_cm;
  errors.rmse_cm = signed_errors.rmse_cm;
}

}  // namespace

MeshErrors evaluate_mesh(const TriangleMesh& reference, const TriangleMesh& estimate, const MeshParams& params) {
  if (reference.vertices_m.empty()) throw InputError("the reference has no points");
  if (estimate.vertices_m.empty()) throw InputError("the estimate has no points");
  const Samples truth = sample_surface(reference, params.samples_per_m2, params.max_samples, params.seed);
  const Samples found = sample_surface(estimate, params.samples_per_m2, params.max_samples, params.seed + 1);
  MeshErrors errors;
  errors.reference_samples = static_cast<int>(truth.points_m.size());
  const SurfaceIndex estimate_surface(estimate, params.e_max_m);
  std::vector<bool> covered;
  for (const Vector3d& p : truth.points_m) covered.push_back(estimate_surface.distance_m(p) < params.e_max_m);
  errors.coverage_percent = 100.0 * static_cast<double>(std::count(covered.begin(), covered.end(), true)) /
                            static_cast<double>(covered.size());
  const SurfaceIndex reference_surface(reference, 4 * params.e_max_m);
  double squares = 0, trimmed = 0;
  int within = 0;
  for (const Vector3d& p : found.points_m) {
    const double d = 100 * reference_surface.distance_m(p);
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
