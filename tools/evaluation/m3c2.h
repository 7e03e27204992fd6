// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The signed distance of M3C2 (Lague, Brodu, Leroux 2013) between two sampled surfaces.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "common/mesh.h"

namespace arpent::evaluation {

struct Samples {
  std::vector<Eigen::Vector3d> points_m;
  std::vector<Eigen::Vector3d> normals;  ///< zero for a cloud without normals
};

/// Points spread uniformly over the surface, with the triangles' normals; a cloud's own points. Deterministic.
[[nodiscard]] Samples sample_surface(const TriangleMesh& mesh, double per_m2, int max_samples, std::uint64_t seed);

struct M3c2Params {
  double normal_radius_m = 0.15;  ///< of the sphere whose reference points give the normal
  double radius_m = 0.075;        ///< of the cylinder along the normal in which both surfaces are averaged
  double half_length_m = 0.0866;  ///< of the cylinder
};

/// For each core point (indices into `reference`) how far the estimate lies on the normal's side [m]; NaN where one of
/// the surfaces has too few points (6 for the normal, 3 in the cylinder). Normals are oriented as the reference's.
[[nodiscard]] std::vector<double> m3c2(const Samples& reference, const std::vector<std::size_t>& core,
                                       const Samples& estimate, const M3c2Params& params);

struct SignedErrors {
  int points = 0;
  double mean_cm = 0;
  double std_cm = 0;
  double rmse_cm = 0;
};
/// NaN counts as not measured.
[[nodiscard]] SignedErrors summarise(const std::vector<double>& errors_m);

}  // namespace arpent::evaluation
