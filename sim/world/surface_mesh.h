// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A world's surfaces as triangles, with what a camera must know about each: where on its texture and on its light map a
// point lies. Shapes become triangles here and nowhere else, so that cameras, ground checks and truth agree.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/world/world.h"

namespace arpent::sim {

/// (a, b) = M p + c for a point p in world coordinates.
struct PlanarMap {
  std::array<float, 4> a{};
  std::array<float, 4> b{};

  [[nodiscard]] Eigen::Vector2f at(const Eigen::Vector3f& p_world_m) const {
    return {a[0] * p_world_m.x() + a[1] * p_world_m.y() + a[2] * p_world_m.z() + a[3],
            b[0] * p_world_m.x() + b[1] * p_world_m.y() + b[2] * p_world_m.z() + b[3]};
  }
};

/// A flat piece of surface: the parallelogram origin + a u + b v (two triangles), or its lower left half (one).
struct Facet {
  Eigen::Vector3f origin_m;
  Eigen::Vector3f u_m;
  Eigen::Vector3f v_m;
  Eigen::Vector3f normal;  ///< unit, towards free space
  PlanarMap pattern_m;     ///< pattern coordinates [m]
  PlanarMap patch;         ///< (a, b) of the parallelogram
  PlanarMap picture;       ///< picture coordinates, 1 is the whole picture, v down
  int texture = 0;         ///< index into World::textures
  int picture_index = -1;  ///< index into SurfaceMesh::pictures, -1: none
  float reflectance = 0;   ///< mean, where there is no picture
  float glow = 0;
  int surface = 0;     ///< which of the world's surfaces; beyond them: the tag cube
  int group = 0;       ///< facets that pass into each other without an edge share a group
  bool sharp = false;  ///< never blurred by texture filtering (tags)
  bool triangle = false;
};

struct SurfaceMesh {
  std::vector<Eigen::Vector3f> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from free space
  std::vector<std::uint32_t> facet_of_triangle;
  std::vector<Facet> facets;
  std::vector<MeshPicture> pictures;
  int groups = 0;
};

/// All surfaces, the tag cube and its stand. Box faces that lie on the ground (z = 0) are left out.
[[nodiscard]] SurfaceMesh make_surface_mesh(const World& world);

/// Adds an upright or turned box (`T_world_box`: its centre) or a prism of `sides` around its z axis; for bodies that
/// move.
void add_box(SurfaceMesh& mesh, const Pose& T_world_box, const Eigen::Vector3d& size_m, int texture, float reflectance);
void add_prism(SurfaceMesh& mesh, const Pose& T_world_base, double radius_m, double height_m, int sides, int texture,
               float reflectance);

}  // namespace arpent::sim
