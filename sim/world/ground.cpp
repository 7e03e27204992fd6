// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/world/ground.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/world/clip.h"
#include "sim/world/surface_mesh.h"

namespace arpent::sim {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Polygon = GroundMap::Polygon;

constexpr double kCellM = 0.5;
constexpr int kCylinderSides = 64;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Distance of the origin to a convex polygon, 0 inside.
double origin_distance(const Polygon& polygon) {
  double nearest = kInfinity;
  bool left = true, right = true, flat = true;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d& a = polygon[i];
    const Vector2d edge = polygon[(i + 1) % polygon.size()] - a;
    const double side = cross(edge, -a);
    left = left && side >= 0;
    right = right && side <= 0;
    flat = flat && std::abs(side) < 1e-12;
    const double length2 = edge.squaredNorm();
    const double t = length2 > 0 ? std::clamp(-a.dot(edge) / length2, 0.0, 1.0) : 0.0;
    nearest = std::min(nearest, (a + t * edge).norm());
  }
  return (left || right) && !flat ? 0 : nearest;
}

/// Into the frame in which the footprint is the unit disc.
Vector2d to_unit(const Vector2d& p, const Pose2& pose, const EllipseFootprint& footprint) {
  const double c = std::cos(pose.yaw_rad), s = std::sin(pose.yaw_rad);
  const Vector2d d = p - pose.position_m();
  return {(c * d.x() + s * d.y()) / footprint.semi_long_m, (-s * d.x() + c * d.y()) / footprint.semi_short_m};
}

bool touches(const Polygon& polygon, const Pose2& pose, const EllipseFootprint& footprint) {
  Polygon turned;
  turned.reserve(polygon.size());
  for (const Vector2d& p : polygon) turned.push_back(to_unit(p, pose, footprint));
  return origin_distance(turned) <= 1;
}

Polygon box_polygon(const Vector3d& centre, const Vector3d& size, double yaw_rad) {
  const Pose2 pose{centre.x(), centre.y(), yaw_rad};
  Polygon polygon;
  for (const auto& [sx, sy] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}}) {
    polygon.emplace_back((pose.to_pose() * Vector3d(sx * size.x(), sy * size.y(), 0)).head<2>());
  }
  return polygon;
}

Polygon circle_polygon(const Vector2d& centre, double radius_m) {
  Polygon polygon;
  for (int k = 0; k < kCylinderSides; ++k) {
    const double angle = 2 * std::numbers::pi * k / kCylinderSides;
    polygon.emplace_back(centre + radius_m * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

/// The smallest convex polygon around points that lie on a line or in a plane seen from above (a clipped face).
Polygon seen_from_above(const std::vector<Vector3d>& face) {
  Polygon polygon;
  for (const Vector3d& p : face) polygon.emplace_back(p.head<2>());
  return polygon;
}

bool in_band(double bottom, double top, double low_m, double high_m) {
  return top > low_m && bottom < high_m;
}

}  // namespace

GroundMap::GroundMap(const World& world, double low_m, double high_m) {
  const auto add_face = [&](const std::vector<Vector3d>& face) {
    const auto above = clip(face, {Vector3d::UnitZ(), low_m}).inside;
    const auto between = clip(above, {-Vector3d::UnitZ(), -high_m}).inside;
    if (!between.empty()) add(seen_from_above(between));
  };
  for (const WorldSurface& surface : world.surfaces) {
    if (const auto* box = std::get_if<BoxShape>(&surface.shape)) {
      const double half = 0.5 * box->size_m.z();
      if (in_band(box->centre_m.z() - half, box->centre_m.z() + half, low_m, high_m)) {
        add(box_polygon(box->centre_m, box->size_m, box->yaw_rad));
      }
    } else if (const auto* cylinder = std::get_if<CylinderShape>(&surface.shape)) {
      const double bottom = cylinder->base_m.z();
      if (in_band(bottom, bottom + cylinder->height_m, low_m, high_m)) {
        add(circle_polygon(cylinder->base_m.head<2>(), cylinder->radius_m));
      }
    } else if (const auto* plane = std::get_if<PlaneShape>(&surface.shape)) {
      const Vector3d& c = plane->corner_m;
      add_face({c, c + plane->u_m, c + plane->u_m + plane->v_m, c + plane->v_m});
    } else if (const auto& mesh = std::get<MeshShape>(surface.shape); mesh.data) {
      for (const auto& t : mesh.data->mesh.triangles) {
        const auto& v = mesh.data->mesh.vertices_m;
        add_face({v[t[0]].cast<double>(), v[t[1]].cast<double>(), v[t[2]].cast<double>()});
      }
    }
  }
  if (world.tag_cube) {
    const TagCube& cube = *world.tag_cube;
    const bool cube_low =
        in_band(cube.centre_m.z() - 0.5 * cube.edge_m, cube.centre_m.z() + 0.5 * cube.edge_m, low_m, high_m);
    const double width = cube_low ? cube.edge_m : cube.stand_m;
    add(box_polygon(cube.centre_m, Vector3d::Constant(width), cube.yaw_rad));
  }
  build_index();
}

void GroundMap::add(Polygon polygon) {
  obstacles_.push_back(std::move(polygon));
}

void GroundMap::build_index() {
  if (obstacles_.empty()) return;
  Vector2d least = obstacles_.front().front(), most = least;
  for (const Polygon& polygon : obstacles_) {
    for (const Vector2d& p : polygon) {
      least = least.cwiseMin(p);
      most = most.cwiseMax(p);
    }
  }
  corner_m_ = least;
  columns_ = 1 + static_cast<int>((most.x() - least.x()) / kCellM);
  rows_ = 1 + static_cast<int>((most.y() - least.y()) / kCellM);
  cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
  for (std::size_t i = 0; i < obstacles_.size(); ++i) {
    Vector2d low = obstacles_[i].front(), high = low;
    for (const Vector2d& p : obstacles_[i]) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    const Eigen::Vector2i first = ((low - corner_m_) / kCellM).cast<int>(),
                          last = ((high - corner_m_) / kCellM).cast<int>();
    for (int row = first.y(); row <= last.y(); ++row) {
      for (int column = first.x(); column <= last.x(); ++column) {
        cells_[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column)]
            .push_back(static_cast<int>(i));
      }
    }
  }
}

template <class Visit>
void GroundMap::visit_cells(int column0, int row0, int column1, int row1, Visit visit) const {
  for (int row = std::max(0, row0); row <= std::min(rows_ - 1, row1); ++row) {
    for (int column = std::max(0, column0); column <= std::min(columns_ - 1, column1); ++column) {
      const auto cell =
          static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
      for (const int i : cells_[cell]) {
        if (visit(obstacles_[static_cast<std::size_t>(i)])) return;
      }
    }
  }
}

bool GroundMap::hits(const Pose2& pose, const EllipseFootprint& footprint) const {
  const double reach = std::max(footprint.semi_long_m, footprint.semi_short_m);
  const Vector2d p = (pose.position_m() - corner_m_) / kCellM;
  const double cells = reach / kCellM;
  const auto cell = [](double x) { return static_cast<int>(std::floor(std::clamp(x, -1e6, 1e6))); };
  bool hit = false;
  visit_cells(cell(p.x() - cells), cell(p.y() - cells), cell(p.x() + cells), cell(p.y() + cells),
              [&](const Polygon& polygon) { return hit = touches(polygon, pose, footprint); });
  return hit;
}

double GroundMap::distance_m(const Vector2d& p_world_m) const {
  if (obstacles_.empty()) return kInfinity;
  // Squares of cells around the point, growing until no obstacle outside can be nearer.
  const Vector2d p = (p_world_m - corner_m_) / kCellM;
  const double outside = std::max({0.0, -p.x(), -p.y(), p.x() - columns_, p.y() - rows_});
  const int column = static_cast<int>(std::floor(p.x())), row = static_cast<int>(std::floor(p.y()));
  double nearest = kInfinity;
  for (int reach = static_cast<int>(outside) + 1;; reach *= 2) {
    visit_cells(column - reach, row - reach, column + reach, row + reach, [&](const Polygon& polygon) {
      Polygon moved;
      for (const Vector2d& q : polygon) moved.push_back(q - p_world_m);
      nearest = std::min(nearest, origin_distance(moved));
      return nearest == 0;
    });
    const bool all = column - reach <= 0 && row - reach <= 0 && column + reach >= columns_ && row + reach >= rows_;
    if (nearest <= reach * kCellM || all) return nearest;
  }
}

bool overlap(const Pose2& a, const EllipseFootprint& footprint_a, const Pose2& b, const EllipseFootprint& footprint_b) {
  // b as a polygon around it: touching is found up to half a millimetre too early.
  constexpr int kCorners = 128;
  const double grow = 1 / std::cos(std::numbers::pi / kCorners);
  Polygon polygon;
  for (int k = 0; k < kCorners; ++k) {
    const double angle = 2 * std::numbers::pi * k / kCorners;
    polygon.emplace_back((b.to_pose() * Vector3d(grow * footprint_b.semi_long_m * std::cos(angle),
                                                 grow * footprint_b.semi_short_m * std::sin(angle), 0))
                             .head<2>());
  }
  return touches(polygon, a, footprint_a);
}

}  // namespace arpent::sim
