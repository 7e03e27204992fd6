// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numbers>

#include "sim/world/world.h"

namespace arpent::sim {
namespace {

const std::string kWorlds = ARPENT_SOURCE_DIR "/config/worlds/";

double area_m2(const TriangleMesh& mesh) {
  double area = 0;
  for (const auto& t : mesh.triangles) {
    const auto& v = mesh.vertices_m;
    area += 0.5 * static_cast<double>((v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).norm());
  }
  return area;
}

/// Floor 8 x 7 without the obstacle's 0.8 x 0.8; walls 2 (8 + 7) 2; the obstacle's sides 4 x 0.8 x 2. Its top, at the
/// region's upper border, is not seen by anybody. The tag cube does not count.
TEST(Truth, TheArenasAreaIsWhatTheDrawingSays) {
  EXPECT_NEAR(area_m2(truth_mesh(load_world(kWorlds + "test_arena.yaml"))), 56 - 0.64 + 60 + 6.4, 0.05);
}

/// Floor and ceiling 21 x 14, walls 2 (21 + 14) 2, three pillars 4 x 0.5 x 2; boxes: sides and top, minus the floor
/// below.
TEST(Truth, TheParkingLotsAreaIsWhatTheDrawingSays) {
  const double pillars = 3 * (4.0 - 2 * 0.25);  // also off the ceiling
  const double big = 3 * (4 * 1.5 * 1.0), long_low = 2 * (2 * (3.0 + 0.5) * 0.8), small = 2 * (2 * (1.5 + 0.5) * 0.5),
               last = 2 * (2.0 + 0.7) * 0.8;
  EXPECT_NEAR(area_m2(truth_mesh(load_world(kWorlds + "parking_lot.yaml"))),
              2 * 21 * 14 + 140 + pillars + big + long_low + small + last, 0.2);
}

TEST(Truth, NormalsPointIntoFreeSpaceAndAgreeWithTheTriangles) {
  const TriangleMesh truth = truth_mesh(load_world(kWorlds + "test_arena.yaml"));
  const Eigen::Vector3f box(4.4F, 3.5F, 1), room(4, 3.5F, 1);
  for (const auto& t : truth.triangles) {
    const auto& v = truth.vertices_m;
    const Eigen::Vector3f normal = (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]).normalized();
    EXPECT_GT(normal.dot(truth.normals[t[0]]), 0.999F);
    const Eigen::Vector3f middle = (v[t[0]] + v[t[1]] + v[t[2]]) / 3;
    const bool obstacle = (middle - box).head<2>().cwiseAbs().maxCoeff() < 0.41F && std::abs(normal.z()) < 0.5F;
    EXPECT_GT(obstacle ? normal.dot(middle - box) : normal.dot(room - middle), 0) << middle.transpose();
  }
}

TEST(Truth, ExcludedPartsAndACylindersShadowAreCutOut) {
  World world;
  world.region = {{0, 0, 0}, {10, 10, 2}};
  world.textures.emplace_back();
  world.surfaces.push_back({PlaneShape{{-1, -1, 0}, {20, 0, 0}, {0, 20, 0}}, 0, 0});
  EXPECT_NEAR(area_m2(truth_mesh(world)), 100, 0.1) << "the region's part of the floor";
  world.excluded.push_back({{2, 2, -1}, {4, 5, 1}});
  EXPECT_NEAR(area_m2(truth_mesh(world)), 94, 0.1);
  world.surfaces.push_back({CylinderShape{{7, 7, 0}, 1, 1}, 0, 0});
  // Its side 2 pi r h and its top pi r^2, which the floor below loses.
  EXPECT_NEAR(area_m2(truth_mesh(world)), 94 + 2 * std::numbers::pi, 0.1);
}

}  // namespace
}  // namespace arpent::sim
