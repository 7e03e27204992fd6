// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/surface/mesh_extraction.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>

#include "mapping/surface/marching_cubes.h"
#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

/// A map of +-3 blocks around the origin whose distances come from a function.
template <class Distance>
TsdfMap fill(const Distance& distance) {
  TsdfParams params;
  params.voxel_m = 0.1;
  TsdfMap map(params);
  TsdfMap::Storage& storage = map.storage();
  storage.revision = 1;
  for (int z = -2; z < 2; ++z) {
    for (int y = -2; y < 2; ++y) {
      for (int x = -2; x < 2; ++x) {
        auto block = std::make_unique<Block>();
        block->index = {x, y, z};
        block->revision = 1;
        for (int i = 0; i < kBlockVoxels; ++i) {
          const VoxelIndex v = 8 * block->index + VoxelIndex(i % 8, i / 8 % 8, i / 64);
          block->distance_m[static_cast<std::size_t>(i)] = static_cast<float>(distance(map.centre_m(v)));
          block->weight[static_cast<std::size_t>(i)] = 0.01F;
        }
        storage.adopt(std::move(block));
      }
    }
  }
  return map;
}

/// How often each directed edge is used by a triangle.
std::map<std::pair<std::uint32_t, std::uint32_t>, int> directed_edges(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  return edges;
}

TEST(MarchingCubes, EveryCrossedEdgeAndNoOtherIsUsed) {
  for (int inside = 0; inside < 256; ++inside) {
    std::set<int> used, crossed;
    for (const auto& triangle : marching_cubes_case(static_cast<std::uint8_t>(inside)))
      used.insert(triangle.begin(), triangle.end());
    for (int e = 0; e < 12; ++e) {
      const auto& [a, b] = kEdgeCorners[static_cast<std::size_t>(e)];
      if ((inside >> a & 1) != (inside >> b & 1)) crossed.insert(e);
    }
    EXPECT_EQ(used, crossed) << inside;
  }
}

TEST(MeshExtraction, ASphereIsWatertightRoundAndFacesOutwards) {
  const double radius = 1.03;
  const TriangleMesh mesh = extract_mesh(fill([&](const Eigen::Vector3d& p) { return p.norm() - radius; }));
  const auto edges = directed_edges(mesh);
  for (const auto& [edge, count] : edges) {
    EXPECT_EQ(count, 1);
    EXPECT_TRUE(edges.contains({edge.second, edge.first})) << "a boundary edge";
  }
  const auto V = static_cast<int>(mesh.vertices_m.size()), F = static_cast<int>(mesh.triangles.size());
  EXPECT_EQ(V - static_cast<int>(edges.size()) / 2 + F, 2) << "Euler characteristic";
  for (std::size_t i = 0; i < mesh.vertices_m.size(); ++i) {
    EXPECT_NEAR(mesh.vertices_m[i].norm(), radius, 0.005);
    EXPECT_GT(mesh.normals[i].dot(mesh.vertices_m[i].normalized()), 0.9F);
  }
}

TEST(MeshExtraction, EvenNoiseGivesASurfaceWithoutCracks) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(-0.15, 0.15);  // as far as distances beside a surface may leap
  const TsdfMap map = fill([&](const Eigen::Vector3d&) { return uniform(generator); });
  const TriangleMesh mesh = extract_mesh(map);
  const auto edges = directed_edges(mesh);
  // Only at the rim of what was seen may the surface end: in the outermost layer of voxel centres.
  const auto at_rim = [&](std::uint32_t v) { return mesh.vertices_m[v].cwiseAbs().maxCoeff() > 1.55F - 0.11F; };
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (at_rim(edge.first) || at_rim(edge.second)) continue;
    ASSERT_NE(back, edges.end());
    EXPECT_EQ(back->second, count);
  }
}

TEST(MeshExtraction, WhatWasNotSeenHasNoSurface) {
  TsdfMap map = fill([](const Eigen::Vector3d& p) { return p.z(); });
  const std::size_t before = extract_mesh(map).triangles.size();
  for (const auto& block : map.storage().blocks) {
    if (block->index.x() >= 0) block->weight.fill(0);
  }
  EXPECT_LT(extract_mesh(map).triangles.size(), before * 6 / 10);
}

TEST(MeshExtraction, WhereFreeSpaceMeetsAGuessBehindAnObjectThereIsNoSurface) {
  // A wall at x = 0, known to 0.3 m behind it; from y = 0 on another view has seen free space in its place.
  const auto distance = [](const Eigen::Vector3d& p) { return p.y() > 0 ? 0.3 : std::max(p.x(), -0.3); };
  const TriangleMesh mesh = extract_mesh(fill(distance));
  double area_m2 = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f ab = mesh.vertices_m[b] - mesh.vertices_m[a], ac = mesh.vertices_m[c] - mesh.vertices_m[a];
    area_m2 += 0.5 * ab.cross(ac).norm();
    for (const auto i : {a, b, c}) EXPECT_GT(mesh.vertices_m[i].x(), -0.1) << "a sheet behind the wall";
  }
  // The map spans 3.1 m of voxel centres in z and 1.5 m in y < 0.
  EXPECT_NEAR(area_m2, 3.1 * 1.5, 0.5) << "the wall itself stays";
}

TEST(MeshExtraction, MeshingOnlyWhatChangedGivesTheSameMesh) {
  TsdfParams params;
  params.voxel_m = 0.1;
  TsdfMap map(params);
  const PinholeCamera camera{96, 80, 60, 60, 47.5, 39.5};
  IncrementalMesher mesher;
  for (int i = 0; i < 6; ++i) {
    const stereo::DepthMap depth{camera, cv::Mat1f(80, 96, 1.5F + 0.07F * static_cast<float>(i)),
                                 cv::Mat1f(80, 96, 0.01F)};
    (void)map.integrate(depth, Pose(Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d::UnitY())));
    EXPECT_GT(mesher.update(map), 0U);
    const TriangleMesh incremental = mesher.mesh(), full = extract_mesh(map);
    EXPECT_EQ(incremental.vertices_m, full.vertices_m);
    EXPECT_EQ(incremental.triangles, full.triangles);
  }
  EXPECT_EQ(mesher.update(map), 0U) << "nothing changed";
}

}  // namespace
}  // namespace arpent::mapping
