// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>

#include "sim/world/clip.h"
#include "sim/world/surface_mesh.h"
#include "sim/world/world.h"

namespace arpent::sim {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr double kTouchM = 0.002;   ///< surfaces nearer than this touch
constexpr double kInsideM = 0.005;  ///< how far in front of a surface must still be inside the region
constexpr int kNoSurface = -1;

/// A convex solid, and the surface that it is made from.
struct Solid {
  std::vector<HalfSpace> half_spaces;
  int surface = kNoSurface;
};

Solid box_solid(const Vector3d& centre, const Vector3d& half, double yaw_rad, int surface) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(yaw_rad, Vector3d::UnitZ()).toRotationMatrix();
  Solid solid{{}, surface};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3d inwards = -side * R.col(axis);
      solid.half_spaces.push_back({inwards, inwards.dot(centre) - half[axis]});
    }
  }
  return solid;
}

Solid prism_solid(const CylinderShape& cylinder, int surface) {
  constexpr int kSides = 64;
  Solid solid{{{Vector3d::UnitZ(), cylinder.base_m.z() - kTouchM},
               {-Vector3d::UnitZ(), -cylinder.base_m.z() - cylinder.height_m - kTouchM}},
              surface};
  const double apothem = cylinder.radius_m * std::cos(std::numbers::pi / kSides) + kTouchM;
  for (int k = 0; k < kSides; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.5) / kSides;
    const Vector3d inwards(-std::cos(angle), -std::sin(angle), 0);
    solid.half_spaces.push_back({inwards, inwards.dot(cylinder.base_m) - apothem});
  }
  return solid;
}

std::vector<Solid> solids_of(const World& world) {
  std::vector<Solid> solids;
  for (const Region& region : world.excluded) {
    solids.push_back(
        box_solid(0.5 * (region.min_m + region.max_m), 0.5 * (region.max_m - region.min_m), 0, kNoSurface));
  }
  for (std::size_t i = 0; i < world.surfaces.size(); ++i) {
    const int surface = static_cast<int>(i);
    if (const auto* box = std::get_if<BoxShape>(&world.surfaces[i].shape)) {
      solids.push_back(
          box_solid(box->centre_m, 0.5 * box->size_m + Vector3d::Constant(kTouchM), box->yaw_rad, surface));
    } else if (const auto* cylinder = std::get_if<CylinderShape>(&world.surfaces[i].shape)) {
      solids.push_back(prism_solid(*cylinder, surface));
    }
  }
  return solids;
}

/// What is left of the pieces outside the solid.
std::vector<Polygon> subtract(const std::vector<Polygon>& pieces, const Solid& solid) {
  std::vector<Polygon> left;
  for (const Polygon& piece : pieces) {
    std::vector<Polygon> parts;
    Polygon rest = piece;
    for (const HalfSpace& half_space : solid.half_spaces) {
      Cut cut = clip(rest, half_space);
      if (!cut.outside.empty()) parts.push_back(std::move(cut.outside));
      rest = std::move(cut.inside);
      if (rest.empty()) break;
    }
    if (rest.empty() && parts.size() > 1) {
      // Nothing of the piece is inside: keep it whole.
      left.push_back(piece);
    } else {
      left.insert(left.end(), parts.begin(), parts.end());
    }
  }
  return left;
}

/// The part of a polygon in front of which the region is.
Polygon within(Polygon polygon, const Region& region, const Vector3d& normal) {
  for (int axis = 0; axis < 3 && !polygon.empty(); ++axis) {
    const double ahead = kInsideM * normal[axis];
    polygon = clip(polygon, {Vector3d::Unit(axis), region.min_m[axis] - ahead - kTouchM}).inside;
    polygon = clip(polygon, {-Vector3d::Unit(axis), -region.max_m[axis] + ahead - kTouchM}).inside;
  }
  return polygon;
}

void add_fan(const Polygon& polygon, const Vector3d& normal, TriangleMesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices_m.size());
  for (const Vector3d& p : polygon) {
    mesh.vertices_m.push_back(p.cast<float>());
    mesh.normals.push_back(normal.cast<float>());
  }
  for (std::uint32_t i = 2; i < polygon.size(); ++i) mesh.triangles.push_back({first, first + i - 1, first + i});
}

}  // namespace

TriangleMesh truth_mesh(const World& world) {
  const SurfaceMesh surfaces = make_surface_mesh(world);
  const std::vector<Solid> solids = solids_of(world);
  TriangleMesh truth;
  for (std::size_t i = 0; i < surfaces.triangles.size(); ++i) {
    const Facet& facet = surfaces.facets[surfaces.facet_of_triangle[i]];
    if (facet.surface >= static_cast<int>(world.surfaces.size())) continue;  // the tag cube
    const Vector3d normal = facet.normal.cast<double>();
    Polygon whole;
    for (const std::uint32_t v : surfaces.triangles[i]) whole.push_back(surfaces.vertices_m[v].cast<double>());
    std::vector<Polygon> pieces;
    if (Polygon part = within(whole, world.region, normal); !part.empty()) pieces.push_back(std::move(part));
    for (const Solid& solid : solids) {
      if (pieces.empty()) break;
      if (solid.surface != facet.surface) pieces = subtract(pieces, solid);
    }
    for (const Polygon& piece : pieces) add_fan(piece, normal, truth);
  }
  return truth;
}

}  // namespace arpent::sim
