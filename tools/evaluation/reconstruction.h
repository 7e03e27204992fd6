// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a reconstructed mesh is worth against the true world, by the thesis' metrics (Sect. 2.6.2, 5.4): coverage within
// half a voxel's diagonal, signed error by M3C2 over what is covered; without the surface that no legal pose of the
// robot's camera could ever see.
#pragma once

#include <memory>

#include "common/config/rig.h"
#include "common/config/robot.h"
#include "tools/evaluation/legal_views.h"
#include "tools/evaluation/m3c2.h"
#include "tools/evaluation/surface_index.h"

namespace arpent::evaluation {

/// One point on each 3 cm x 3 cm. The thesis has 10^4 points on a square metre; shares of the surface and means over
/// 10^5 points do not need them.
inline constexpr double kSamplesPerM2 = 1 / (0.03 * 0.03);

/// e_max [m] = r_v sqrt(3) / 2: 8.66 cm for voxels of 10 cm, 17.32 cm for 20 cm.
[[nodiscard]] double e_max_m(double voxel_m);

/// Footprint and camera of a robot.
[[nodiscard]] LegalViewParams legal_view_params(const RobotConfig& robot, const StereoCalibration& rig,
                                                double min_range_m, double max_range_m);

/// The true surface that counts, as points spread uniformly by area.
struct TrueSurface {
  TriangleMesh mesh;  ///< of the region, without what is excluded
  Samples visible;
  Samples hidden;      ///< that no legal pose sees
  double area_m2 = 0;  ///< of both

  [[nodiscard]] double visible_percent() const {
    const auto seen = static_cast<double>(visible.points_m.size());
    return 100 * seen / std::max(1.0, seen + static_cast<double>(hidden.points_m.size()));
  }
};
/// Throws InputError if nothing of the surface can be seen.
[[nodiscard]] TrueSurface find_true_surface(const sim::World& world, const LegalViews& views,
                                            double samples_per_m2 = kSamplesPerM2);

struct Reconstruction {
  double e_max_m = 0;
  double coverage_percent = 0;
  SignedErrors errors;                ///< M3C2, over covered points; positive: in front of the true surface
  double beyond_percent = 0;          ///< share of the mesh farther than e_max from all true surface: ghosts
  std::vector<std::uint8_t> covered;  ///< of each visible point
  std::vector<std::size_t> core;      ///< of visible points, those that M3C2 was asked about
  std::vector<double> core_error_m;   ///< NaN: not measured
};
/// M3C2: normals of the truth within a sphere of 3 r_v diameter, both surfaces averaged in a cylinder of 1.5 r_v
/// diameter and e_max half-length; at each fourth covered point. An empty mesh covers nothing.
[[nodiscard]] Reconstruction evaluate_reconstruction(const TrueSurface& truth, const TriangleMesh& mesh,
                                                     double voxel_m);

/// Only the coverage [%]: for curves over time.
[[nodiscard]] double coverage_percent(const TrueSurface& truth, const TriangleMesh& mesh, double voxel_m);

/// Signed distance [m] of each vertex from the nearest true surface (positive in front of it); NaN beyond `limit_m`.
[[nodiscard]] std::vector<float> vertex_errors(const TriangleMesh& truth, const TriangleMesh& mesh, double limit_m);

}  // namespace arpent::evaluation
