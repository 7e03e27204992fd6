// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A reconstructed mesh against the true surface: coverage, accuracy, and the signed distance of M3C2 (Lague, Brodu,
// Leroux 2013).
#pragma once

#include <cstdint>

#include "common/mesh.h"
#include "tools/evaluation/m3c2.h"

namespace arpent::evaluation {

struct MeshParams {
  double e_max_m = 0.0866;      ///< a reference point is covered if the estimate is nearer than this
  double samples_per_m2 = 400;  ///< on the reference (and the estimate), drawn uniformly by area
  int max_samples = 200000;
  std::uint64_t seed = 1;
  // M3C2: normals from the reference within a sphere of diameter `normal_scale`, mean positions within cylinders of
  // diameter `projection_scale`. Zero: 4 e_max and 2 e_max.
  double normal_scale_m = 0;
  double projection_scale_m = 0;
};

struct MeshErrors {
  int reference_samples = 0;
  double coverage_percent = 0;
  double accuracy_rmse_cm = 0;  ///< estimate's samples to the reference, all
  double accuracy_trim_cm = 0;  ///< only those within e_max
  double beyond_percent = 0;    ///< share of the estimate's samples that are not
  int m3c2_points = 0;          ///< covered points where M3C2 found both surfaces
  double mean_cm = 0;           ///< M3C2, positive where the estimate lies on the normal's side
  double std_cm = 0;
  double rmse_cm = 0;
};

/// Either may be a mesh or (without triangles) a cloud; a cloud's points are used as they are. Throws InputError if one
/// is empty.
[[nodiscard]] MeshErrors evaluate_mesh(const TriangleMesh& reference, const TriangleMesh& estimate,
                                       const MeshParams& params);

}  // namespace arpent::evaluation
