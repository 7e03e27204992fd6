// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation/reconstruction.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "common/error.h"
#include "tests/tools/evaluation/small_worlds.h"

namespace arpent::evaluation {
namespace {

using Eigen::Vector3d;

constexpr double kVoxelM = 0.1;

TrueSurface surface_of(const sim::World& world) {
  return find_true_surface(world, LegalViews(world, world.starts.front(), small_robot()));
}

/// The mesh moved along its own normals.
TriangleMesh inflated(TriangleMesh mesh, double by_m) {
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i)
    mesh.vertices_m[i] += static_cast<float>(by_m) * mesh.normals[i];
  return mesh;
}

/// Without the triangles whose corners all fulfil `drop`.
template <class Drop>
TriangleMesh without(TriangleMesh mesh, const Drop& drop) {
  std::erase_if(mesh.triangles, [&](const auto& t) {
    return std::all_of(t.begin(), t.end(), [&](auto v) { return drop(mesh.vertices_m[v]); });
  });
  return mesh;
}

std::size_t count_if(const std::vector<Vector3d>& points, const std::function<bool(const Vector3d&)>& test) {
  return static_cast<std::size_t>(std::count_if(points.begin(), points.end(), test));
}

TEST(Reconstruction, TheBoundsAreThoseOfTheThesis) {
  EXPECT_NEAR(e_max_m(0.1), 0.0866, 1e-4);
  EXPECT_NEAR(e_max_m(0.2), 0.1732, 1e-4);
}

TEST(Reconstruction, TheTruthItselfIsCompleteAndExact) {
  const TrueSurface truth = surface_of(room_with(""));
  EXPECT_NEAR(truth.area_m2, 5 * 4 + 2 * 1.5 * (5 + 4), 1e-3);
  EXPECT_NEAR(truth.visible_percent(), 100, 0.1);
  const auto result = evaluate_reconstruction(truth, truth.mesh, kVoxelM);
  EXPECT_NEAR(result.coverage_percent, 100, 1e-9);
  EXPECT_GT(result.errors.points, 8000);
  EXPECT_LT(result.errors.rmse_cm, 0.3) << "two samplings of the same surface, bent at edges";
  EXPECT_NEAR(result.beyond_percent, 0, 1e-9);
}

TEST(Reconstruction, AShiftedSurfaceErrsByItsShiftAndSign) {
  const TrueSurface truth = surface_of(room_with(""));
  const auto result = evaluate_reconstruction(truth, inflated(truth.mesh, 0.03), kVoxelM);
  EXPECT_NEAR(result.coverage_percent, 100, 1e-9);
  EXPECT_NEAR(result.errors.mean_cm, 3, 0.1);
  EXPECT_NEAR(result.errors.rmse_cm, 3, 0.1);
  EXPECT_LT(evaluate_reconstruction(truth, inflated(truth.mesh, -0.03), kVoxelM).errors.mean_cm, -2.8);
  // Beyond e_max each surface is lost, but along the 18 m of the floor's edges and the 6 m of the walls' a strip of
  // twice e_max of both sides is near the other side's shifted plane.
  const double strips = 100 * 2 * (18 + 6) * 2 * 0.0866 / 47;
  EXPECT_NEAR(evaluate_reconstruction(truth, inflated(truth.mesh, 0.09), kVoxelM).coverage_percent, strips, 1);
  TriangleMesh points;
  points.vertices_m = {{2, 2, 0.03F}, {2, 2, -0.02F}, {4.96F, 2, 1}, {2, 2, 0.5F}};
  const auto errors = vertex_errors(truth.mesh, points, 0.1);
  EXPECT_NEAR(errors[0], 0.03, 1e-5);
  EXPECT_NEAR(errors[1], -0.02, 1e-5);
  EXPECT_NEAR(errors[2], 0.04, 1e-5);
  EXPECT_TRUE(std::isnan(errors[3])) << "far from everything";
}

TEST(Reconstruction, NoiseShowsInTheDeviationNotInTheMean) {
  // A surface as a cloud of small triangles, each moved along its normal by noise of 2 cm: means over the cylinder take
  // most of it out, the rest has zero mean.
  const TrueSurface truth = surface_of(room_with(""));
  std::mt19937 generator(3);
  std::normal_distribution<float> noise(0, 0.02F);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < truth.visible.points_m.size(); ++i) {
    const Eigen::Vector3f n = truth.visible.normals[i].cast<float>();
    const Eigen::Vector3f p = truth.visible.points_m[i].cast<float>() + noise(generator) * n;
    const Eigen::Vector3f u = 0.02F * n.unitOrthogonal(), v = n.cross(u);
    const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
    for (const auto& corner : {u, Eigen::Vector3f(-0.5F * u + 0.87F * v), Eigen::Vector3f(-0.5F * u - 0.87F * v)})
      mesh.vertices_m.emplace_back(p + corner);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const auto result = evaluate_reconstruction(truth, mesh, kVoxelM);
  EXPECT_GT(result.coverage_percent, 99.9);
  EXPECT_NEAR(result.errors.mean_cm, 0, 0.1);
  EXPECT_GT(result.errors.std_cm, 0.2);
  EXPECT_LT(result.errors.std_cm, 1.0);
}

TEST(Reconstruction, CoverageIsTheShareOfTheAreaThatIsThere) {
  const TrueSurface truth = surface_of(room_with(""));
  // Without the wall x = 5 (6 m2 of 47): what is within e_max of floor and two walls still counts.
  const auto mesh = without(truth.mesh, [](const Eigen::Vector3f& p) { return p.x() > 4.999F; });
  const double missing = (4 - 2 * 0.0866) * (1.5 - 0.0866);
  EXPECT_NEAR(evaluate_reconstruction(truth, mesh, kVoxelM).coverage_percent, 100 * (1 - missing / 47), 0.2);
  EXPECT_NEAR(coverage_percent(truth, mesh, kVoxelM), 100 * (1 - missing / 47), 0.2);
  EXPECT_EQ(coverage_percent(truth, TriangleMesh{}, kVoxelM), 0);
  EXPECT_EQ(evaluate_reconstruction(truth, TriangleMesh{}, kVoxelM).errors.points, 0);
}

TEST(Reconstruction, GhostsLieBeyondTheBound) {
  const TrueSurface truth = surface_of(room_with(""));
  TriangleMesh mesh = truth.mesh;
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const auto& p : {Eigen::Vector3f(2, 1, 1), Eigen::Vector3f(3, 1, 1), Eigen::Vector3f(2, 3, 1)}) {
    mesh.vertices_m.push_back(p);
    mesh.normals.emplace_back(0, 0, 1);
  }
  mesh.triangles.push_back({first, first + 1, first + 2});
  EXPECT_NEAR(evaluate_reconstruction(truth, mesh, kVoxelM).beyond_percent, 100.0 * 1 / 48, 0.1);
}

TEST(Reconstruction, SurfaceThatNoLegalPoseSeesDoesNotCount) {
  // A crate, a hollow made of three walls that nobody can look into, and a box flat on the floor.
  const auto world = room_with(R"(  - box: {centre_m: [3, 1, 0.2], size_m: [0.6, 0.6, 0.4], texture: plain}
  - box: {centre_m: [4.2, 3.5, 0.75], size_m: [0.1, 1.0, 1.5], texture: plain}
  - box: {centre_m: [4.6, 3.05, 0.75], size_m: [0.9, 0.1, 1.5], texture: plain}
)");
  const TrueSurface truth = surface_of(world);
  const auto in_hollow = [](const Vector3d& p) { return p.x() > 4.26 && p.y() > 3.11; };
  const auto under_crate = [](const Vector3d& p) {
    return std::abs(p.x() - 3) < 0.29 && std::abs(p.y() - 1) < 0.29 && p.z() < 0.01;
  };
  const auto on_crate = [](const Vector3d& p) {
    return (p - Vector3d(3, 1, 0.4)).cwiseAbs().maxCoeff() < 0.28 && p.z() > 0.399;
  };
  EXPECT_EQ(count_if(truth.visible.points_m, in_hollow), 0U);
  EXPECT_GT(count_if(truth.hidden.points_m, in_hollow), 500U);
  EXPECT_EQ(count_if(truth.visible.points_m, under_crate), 0U);
  EXPECT_EQ(count_if(truth.visible.points_m, on_crate), 0U) << "its top is at the camera's height";
  EXPECT_GT(count_if(truth.visible.points_m, [](const Vector3d& p) { return p.x() > 2.69 && p.x() < 2.71; }), 50U)
      << "its side is seen";
  // A mesh without all of it is complete nevertheless.
  const auto mesh = without(truth.mesh, [](const Eigen::Vector3f& p) { return p.x() > 4.24F && p.y() > 3.09F; });
  EXPECT_GT(coverage_percent(truth, mesh, kVoxelM), 99.9);
}

TEST(Reconstruction, AWorldWithoutSurfaceIsRefused) {
  auto world = room_with("");
  const LegalViews views(world, world.starts.front(), small_robot());
  world.surfaces.clear();
  EXPECT_THROW((void)find_true_surface(world, views), InputError);
}

}  // namespace
}  // namespace arpent::evaluation
