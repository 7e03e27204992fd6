// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/surface_mesh.h"

#include <cmath>
#include <map>
#include <numbers>

namespace arpent::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCylinderSides = 64;

/// The affine map that takes the origin to `at_origin`, origin + u to `at_u`, origin + v to `at_v`, and does not change
/// along the normal.
PlanarMap make_map(const Vector3d& origin, const Vector3d& u, const Vector3d& v, const Vector2d& at_origin,
                   const Vector2d& at_u, const Vector2d& at_v) {
  Eigen::Matrix3d axes;
  axes << u, v, u.cross(v).normalized();
  const Eigen::Matrix3d inverse = axes.inverse();
  PlanarMap map;
  for (int k = 0; k < 2; ++k) {
    const Eigen::RowVector3d row =
        (at_u[k] - at_origin[k]) * inverse.row(0) + (at_v[k] - at_origin[k]) * inverse.row(1);
    auto& out = k == 0 ? map.a : map.b;
    for (std::size_t i = 0; i < 3; ++i) out[i] = static_cast<float>(row[static_cast<int>(i)]);
    out[3] = static_cast<float>(at_origin[k] - row.dot(origin));
  }
  return map;
}

/// A facet whose pattern starts at `pattern_origin_m` and runs along u and (nearly) v in true metres.
Facet make_facet(const Vector3d& origin, const Vector3d& u, const Vector3d& v, const Vector2d& pattern_origin_m) {
  Facet facet;
  facet.origin_m = origin.cast<float>();
  facet.u_m = u.cast<float>();
  facet.v_m = v.cast<float>();
  facet.normal = u.cross(v).normalized().cast<float>();
  facet.patch = make_map(origin, u, v, {0, 0}, {1, 0}, {0, 1});
  const Vector3d along = u.normalized();
  const Vector3d across = u.cross(v).normalized().cross(along);
  const auto metres = [&](const Vector3d& p) { return Vector2d(along.dot(p), across.dot(p)); };
  facet.pattern_m =
      make_map(origin, u, v, pattern_origin_m, pattern_origin_m + metres(u), pattern_origin_m + metres(v));
  return facet;
}

/// What all facets of a surface share.
struct Look {
  int texture = 0;
  float reflectance = 0;
  float glow = 0;
  int surface = 0;
};

void take_look(Facet& facet, const Look& look) {
  facet.texture = look.texture;
  facet.reflectance = look.reflectance;
  facet.glow = look.glow;
  facet.surface = look.surface;
}

void add_triangle(SurfaceMesh& mesh, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const Vector3d& p : {a, b, c}) mesh.vertices_m.push_back(p.cast<float>());
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.facet_of_triangle.push_back(static_cast<std::uint32_t>(mesh.facets.size() - 1));
}

/// A parallelogram seen from the side of u x v.
void add_plane(SurfaceMesh& mesh, const Vector3d& origin, const Vector3d& u, const Vector3d& v, Vector2d pattern_origin,
               const Look& look, int group) {
  Facet facet = make_facet(origin, u, v, pattern_origin);
  take_look(facet, look);
  facet.group = group;
  mesh.facets.push_back(facet);
  add_triangle(mesh, origin, origin + u, origin + u + v);
  add_triangle(mesh, origin, origin + u + v, origin + v);
}

/// Different surfaces, and different sides of one, show different parts of their pattern; verticals keep their height,
/// so that seams stand where they belong.
Vector2d pattern_start(const Look& look, int side) {
  return {0.37 * look.surface + 0.61 * side, 0};
}

void add_box_faces(SurfaceMesh& mesh, const Pose& T, const Vector3d& size, const Look& look) {
  const Vector3d half = 0.5 * size;
  const auto face = [&](const Vector3d& n, const Vector3d& right, int side) {
    const Vector3d up = n.cross(right);
    const Vector3d corner = n.cwiseProduct(half) - right.cwiseAbs().dot(half) * right - up.cwiseAbs().dot(half) * up;
    const Vector3d origin = T * corner;
    add_plane(mesh, origin, T.linear() * (2 * right.cwiseAbs().dot(half) * right),
              T.linear() * (2 * up.cwiseAbs().dot(half) * up), pattern_start(look, side), look, mesh.groups++);
  };
  face(Vector3d::UnitX(), Vector3d::UnitY(), 0);
  face(Vector3d::UnitY(), -Vector3d::UnitX(), 1);
  face(-Vector3d::UnitX(), -Vector3d::UnitY(), 2);
  face(-Vector3d::UnitY(), Vector3d::UnitX(), 3);
  face(Vector3d::UnitZ(), Vector3d::UnitX(), 4);
  const bool on_ground = T.translation().z() - half.z() < 1e-9;
  if (!on_ground) face(-Vector3d::UnitZ(), -Vector3d::UnitX(), 5);
}

void add_disc(SurfaceMesh& mesh, const Pose& T, double radius, double z, bool up, int sides, const Look& look) {
  const int group = mesh.groups++;
  const auto rim = [&](int k) {
    const double angle = 2 * std::numbers::pi * k / sides;
    return Vector3d(radius * std::cos(angle), radius * std::sin(angle), z);
  };
  const Vector3d x = T.linear() * Vector3d(1, 0, 0), y = T.linear() * Vector3d(0, up ? 1 : -1, 0);
  const Vector3d corner = T * Vector3d(0, 0, z) - radius * (x + y);
  Facet facet = make_facet(corner, 2 * radius * x, 2 * radius * y, pattern_start(look, up ? 4 : 5));
  take_look(facet, look);
  facet.group = group;
  mesh.facets.push_back(facet);
  for (int k = 0; k < sides; ++k) {
    const Vector3d a = T * rim(k), b = T * rim(k + 1);
    add_triangle(mesh, T * Vector3d(0, 0, z), up ? a : b, up ? b : a);
  }
}

void add_prism_faces(SurfaceMesh& mesh, const Pose& T, double radius, double height, int sides, const Look& look) {
  const int group = mesh.groups++;
  const double side_m = 2 * radius * std::sin(std::numbers::pi / sides);
  for (int k = 0; k < sides; ++k) {
    const double a0 = 2 * std::numbers::pi * k / sides, a1 = 2 * std::numbers::pi * (k + 1) / sides;
    const Vector3d p0 = T * Vector3d(radius * std::cos(a0), radius * std::sin(a0), 0);
    const Vector3d p1 = T * Vector3d(radius * std::cos(a1), radius * std::sin(a1), 0);
    const Vector2d start = pattern_start(look, 0) + Vector2d(side_m * k, 0);
    add_plane(mesh, p0, p1 - p0, T.linear() * Vector3d(0, 0, height), start, look, group);
  }
  add_disc(mesh, T, radius, height, true, sides, look);
  if (T.translation().z() > 1e-9) add_disc(mesh, T, radius, 0, false, sides, look);
}

/// Facets of one plane, texture and picture share a group; curved meshes get one for each facet.
using PlaneKey = std::array<int, 5>;
PlaneKey plane_key(const Facet& facet) {
  const float d = facet.normal.dot(facet.origin_m);
  const auto rounded = [](float x, float scale) { return static_cast<int>(std::lround(x * scale)); };
  return {rounded(facet.normal.x(), 200), rounded(facet.normal.y(), 200), rounded(facet.normal.z(), 200),
          rounded(d, 100), facet.picture_index};
}

/// Pattern coordinates of a mesh: the world's own, seen along the axis nearest to the normal.
PlanarMap world_pattern(const Eigen::Vector3f& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  PlanarMap map;
  map.a[axis == 0 ? 1 : 0] = 1;
  map.b[axis == 2 ? 1 : 2] = 1;
  return map;
}

void add_mesh(SurfaceMesh& mesh, const MeshData& data, const Look& look) {
  const int first_picture = static_cast<int>(mesh.pictures.size());
  mesh.pictures.insert(mesh.pictures.end(), data.pictures.begin(), data.pictures.end());
  std::map<PlaneKey, int> groups;
  for (std::size_t i = 0; i < data.mesh.triangles.size(); ++i) {
    const auto& t = data.mesh.triangles[i];
    const Vector3d a = data.mesh.vertices_m[t[0]].cast<double>(), b = data.mesh.vertices_m[t[1]].cast<double>(),
                   c = data.mesh.vertices_m[t[2]].cast<double>();
    Facet facet = make_facet(a, b - a, c - a, {0, 0});
    take_look(facet, look);
    facet.triangle = true;
    facet.pattern_m = world_pattern(facet.normal);
    if (data.picture_of_triangle[i] >= 0) {
      facet.picture_index = first_picture + data.picture_of_triangle[i];
      const auto& uv = data.picture_uv[i];
      const auto flip = [](const Eigen::Vector2f& p) { return Vector2d(p.x(), 1 - p.y()); };
      facet.picture = make_map(a, b - a, c - a, flip(uv[0]), flip(uv[1]), flip(uv[2]));
    } else {
      facet.reflectance = data.reflectance_of_triangle[i] * look.reflectance;
    }
    const auto [entry, fresh] = groups.emplace(plane_key(facet), mesh.groups);
    if (fresh) ++mesh.groups;
    facet.group = entry->second;
    mesh.facets.push_back(facet);
    add_triangle(mesh, a, b, c);
  }
}

MeshPicture tag_picture(int id) {
  constexpr int kCell = 51;  // 510 texels for ten cells: below 0.6 mm each on a face of 0.3 m
  const auto cells = tag_cells(id);
  MeshPicture picture{10 * kCell, 10 * kCell, {}};
  for (int v = 0; v < picture.height_px; ++v) {
    for (int u = 0; u < picture.width_px; ++u) {
      // Print and paper: neither black nor white is perfect.
      const bool white = cells[static_cast<std::size_t>(10 * (v / kCell) + u / kCell)] > 127;
      picture.values.push_back(white ? 215 : 18);
    }
  }
  return picture;
}

void add_tag_cube(SurfaceMesh& mesh, const TagCube& cube, int surface) {
  const Look look{0, 0.6F, 0, surface};
  Pose T = Pose::Identity();
  T.linear() = Eigen::AngleAxisd(cube.yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
  const double below = cube.centre_m.z() - 0.5 * cube.edge_m;
  if (below > 0) {
    T.translation() = Vector3d(cube.centre_m.x(), cube.centre_m.y(), 0.5 * below);
    add_box_faces(mesh, T, {cube.stand_m, cube.stand_m, below}, look);
  }
  T.translation() = cube.centre_m;
  const std::size_t first = mesh.facets.size();
  add_box_faces(mesh, T, Vector3d::Constant(cube.edge_m), look);
  for (std::size_t k = 0; k < 4; ++k) {
    Facet& face = mesh.facets[first + k];
    face.picture_index = static_cast<int>(mesh.pictures.size());
    face.picture = make_map(face.origin_m.cast<double>(), face.u_m.cast<double>(), face.v_m.cast<double>(), {0, 1},
                            {1, 1}, {0, 0});
    face.sharp = true;
    mesh.pictures.push_back(tag_picture(cube.ids[k]));
  }
}

}  // namespace

void add_box(SurfaceMesh& mesh, const Pose& T_world_box, const Vector3d& size_m, int texture, float reflectance) {
  add_box_faces(mesh, T_world_box, size_m, {texture, reflectance, 0, 0});
}

void add_prism(SurfaceMesh& mesh, const Pose& T_world_base, double radius_m, double height_m, int sides, int texture,
               float reflectance) {
  add_prism_faces(mesh, T_world_base, radius_m, height_m, sides, {texture, reflectance, 0, 0});
}

SurfaceMesh make_surface_mesh(const World& world) {
  SurfaceMesh mesh;
  for (std::size_t i = 0; i < world.surfaces.size(); ++i) {
    const WorldSurface& surface = world.surfaces[i];
    const auto mean = static_cast<float>(world.textures[surface.texture].mean);
    const Look look{static_cast<int>(surface.texture), mean, static_cast<float>(surface.glow), static_cast<int>(i)};
    if (const auto* plane = std::get_if<PlaneShape>(&surface.shape)) {
      add_plane(mesh, plane->corner_m, plane->u_m, plane->v_m, pattern_start(look, 0), look, mesh.groups++);
    } else if (const auto* box = std::get_if<BoxShape>(&surface.shape)) {
      Pose T = Pose::Identity();
      T.linear() = Eigen::AngleAxisd(box->yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
      T.translation() = box->centre_m;
      add_box_faces(mesh, T, box->size_m, look);
    } else if (const auto* cylinder = std::get_if<CylinderShape>(&surface.shape)) {
      Pose T = Pose::Identity();
      T.translation() = cylinder->base_m;
      add_prism_faces(mesh, T, cylinder->radius_m, cylinder->height_m, kCylinderSides, look);
    } else if (const auto* file = std::get_if<MeshShape>(&surface.shape); file->data) {
      add_mesh(mesh, *file->data, look);
    }
  }
  if (world.tag_cube) add_tag_cube(mesh, *world.tag_cube, static_cast<int>(world.surfaces.size()));
  return mesh;
}

}  // namespace arpent::sim
