// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/reconstruction.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "common/error.h"
#include "perception/stereo/rectifier.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector3d;

constexpr int kMaxSamples = 4000000;
constexpr std::size_t kCoreStep = 4;
/// The estimate's samples shall not fall onto the truth's.
constexpr std::uint64_t kTruthSeed = 1, kMeshSeed = 2;

Vector3d normal_of(const std::array<Vector3d, 3>& t) {
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

double area_m2(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f n = (mesh.vertices_m[b] - mesh.vertices_m[a]).cross(mesh.vertices_m[c] - mesh.vertices_m[a]);
    sum += 0.5 * static_cast<double>(n.norm());
  }
  return sum;
}

std::vector<std::uint8_t> find_covered(const TrueSurface& truth, const TriangleMesh& mesh, double limit_m) {
  std::vector<std::uint8_t> covered(truth.visible.points_m.size(), 0);
  if (mesh.triangles.empty()) return covered;
  const SurfaceIndex index(mesh, limit_m);
  for (std::size_t i = 0; i < covered.size(); ++i) covered[i] = index.has_near(truth.visible.points_m[i]) ? 1 : 0;
  return covered;
}

double percent_of(const std::vector<std::uint8_t>& covered) {
  const auto count = std::count(covered.begin(), covered.end(), 1);
  return 100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, covered.size()));
}

double beyond_percent(const TriangleMesh& truth, const Samples& found, double limit_m) {
  const SurfaceIndex index(truth, limit_m);
  const auto count = std::count_if(found.points_m.begin(), found.points_m.end(),
                                   [&](const Vector3d& p) { return !index.has_near(p); });
  return 100.0 * static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, found.points_m.size()));
}

}  // namespace

double e_max_m(double voxel_m) {
  return 0.5 * std::numbers::sqrt3 * voxel_m;
}

LegalViewParams legal_view_params(const RobotConfig& robot, const StereoCalibration& rig, double min_range_m,
                                  double max_range_m) {
  const stereo::Rectifier rectifier(rig);
  LegalViewParams params;
  params.footprint = {robot.semi_axis_long_m, robot.semi_axis_short_m};
  params.camera =
      planning::make_level_camera(rectifier.stereo(), rectifier.T_body_rectified(), min_range_m, max_range_m);
  return params;
}

TrueSurface find_true_surface(const sim::World& world, const LegalViews& views, double samples_per_m2) {
  TrueSurface truth;
  truth.mesh = sim::truth_mesh(world);
  if (truth.mesh.triangles.empty()) throw InputError(world.name + ": there is no surface in the region");
  truth.area_m2 = area_m2(truth.mesh);
  const Samples all = sample_surface(truth.mesh, samples_per_m2, kMaxSamples, kTruthSeed);
  for (std::size_t i = 0; i < all.points_m.size(); ++i) {
    Samples& side = views.see(all.points_m[i], all.normals[i]) ? truth.visible : truth.hidden;
    side.points_m.push_back(all.points_m[i]);
    side.normals.push_back(all.normals[i]);
  }
  if (truth.visible.points_m.empty()) throw InputError(world.name + ": no surface can be seen from the start");
  return truth;
}

Reconstruction evaluate_reconstruction(const TrueSurface& truth, const TriangleMesh& mesh, double voxel_m) {
  Reconstruction result;
  result.e_max_m = e_max_m(voxel_m);
  result.covered = find_covered(truth, mesh, result.e_max_m);
  result.coverage_percent = percent_of(result.covered);
  if (mesh.triangles.empty()) return result;
  std::size_t count = 0;
  for (std::size_t i = 0; i < result.covered.size(); ++i) {
    if (result.covered[i] != 0 && count++ % kCoreStep == 0) result.core.push_back(i);
  }
  const double density =
      static_cast<double>(truth.visible.points_m.size() + truth.hidden.points_m.size()) / truth.area_m2;
  const Samples found = sample_surface(mesh, density, kMaxSamples, kMeshSeed);
  result.core_error_m = m3c2(truth.visible, result.core, found, {1.5 * voxel_m, 0.75 * voxel_m, result.e_max_m});
  result.errors = summarise(result.core_error_m);
  result.beyond_percent = beyond_percent(truth.mesh, found, result.e_max_m);
  return result;
}

double coverage_percent(const TrueSurface& truth, const TriangleMesh& mesh, double voxel_m) {
  return percent_of(find_covered(truth, mesh, e_max_m(voxel_m)));
}

std::vector<float> vertex_errors(const TriangleMesh& truth, const TriangleMesh& mesh, double limit_m) {
  const SurfaceIndex index(truth, limit_m);
  std::vector<float> errors;
  errors.reserve(mesh.vertices_m.size());
  for (const Eigen::Vector3f& vertex : mesh.vertices_m) {
    const Vector3d p = vertex.cast<double>();
    const auto nearest = index.nearest(p);
    if (nearest.index < 0) {
      errors.push_back(std::numeric_limits<float>::quiet_NaN());
      continue;
    }
    const auto corners = index.corners(static_cast<std::size_t>(nearest.index));
    const double side = normal_of(corners).dot(p - corners[0]);
    errors.push_back(static_cast<float>(std::copysign(nearest.distance_m, side)));
  }
  return errors;
}

}  // namespace arpent::evaluation
