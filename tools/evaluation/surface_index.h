// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Finding what is near a point: buckets of a regular grid, and on them the distance to a mesh.
#pragma once

#include <Eigen/Core>
#include <array>
#include <unordered_map>
#include <vector>

#include "common/mesh.h"

namespace arpent::evaluation {

/// Buckets of a regular grid: what lies within one cell's edge of a point is in the 27 cells around it.
class PointGrid {
 public:
  using Cell = Eigen::Vector3i;

  explicit PointGrid(double edge_m) : edge_m_(edge_m) {}
  PointGrid(const std::vector<Eigen::Vector3d>& points_m, double edge_m) : edge_m_(edge_m) {
    for (std::size_t i = 0; i < points_m.size(); ++i) add(points_m[i], static_cast<int>(i));
  }

  void add(const Eigen::Vector3d& p, int index) { cells_[cell(p)].push_back(index); }
  void add_box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int index) {
    const Cell a = cell(low), b = cell(high);
    for (int z = a.z(); z <= b.z(); ++z) {
      for (int y = a.y(); y <= b.y(); ++y) {
        for (int x = a.x(); x <= b.x(); ++x) cells_[{x, y, z}].push_back(index);
      }
    }
  }

  /// Calls visit(index) for everything in the 27 cells around p.
  template <class Visit>
  void around(const Eigen::Vector3d& p, const Visit& visit) const {
    (void)any_around(p, [&](int index) {
      visit(index);
      return false;
    });
  }
  /// The same until visit(index) returns true; whether it did.
  template <class Visit>
  [[nodiscard]] bool any_around(const Eigen::Vector3d& p, const Visit& visit) const {
    const Cell centre = cell(p);
    for (const int z : {0, -1, 1}) {
      for (const int y : {0, -1, 1}) {
        for (const int x : {0, -1, 1}) {
          const auto found = cells_.find(centre + Cell(x, y, z));
          if (found == cells_.end()) continue;
          for (const int index : found->second) {
            if (visit(index)) return true;
          }
        }
      }
    }
    return false;
  }

 private:
  struct Hash {
    std::size_t operator()(const Cell& c) const {
      return static_cast<std::size_t>(c.x()) * 73856093U ^ static_cast<std::size_t>(c.y()) * 19349663U ^
             static_cast<std::size_t>(c.z()) * 83492791U;
    }
  };
  [[nodiscard]] Cell cell(const Eigen::Vector3d& p) const { return (p / edge_m_).array().floor().cast<int>(); }

  double edge_m_;
  std::unordered_map<Cell, std::vector<int>, Hash> cells_;
};

/// Nearest distance to a mesh or (without triangles) a cloud, exact up to `limit_m`. Keeps a reference to the mesh.
class SurfaceIndex {
 public:
  SurfaceIndex(const TriangleMesh& mesh, double limit_m);

  struct Nearest {
    double distance_m = 0;  ///< the limit if there is nothing within it
    int index = -1;         ///< triangle (or point); -1 if there is none
  };
  [[nodiscard]] Nearest nearest(const Eigen::Vector3d& p) const;
  [[nodiscard]] double distance_m(const Eigen::Vector3d& p) const { return nearest(p).distance_m; }
  /// Whether anything is nearer than the limit; quicker than the distance.
  [[nodiscard]] bool has_near(const Eigen::Vector3d& p) const;
  [[nodiscard]] std::array<Eigen::Vector3d, 3> corners(std::size_t triangle) const;

 private:
  [[nodiscard]] double distance_to(int index, const Eigen::Vector3d& p) const;

  const TriangleMesh& mesh_;
  double limit_m_;
  PointGrid grid_;
};

/// Distance from a point to a triangle.
[[nodiscard]] double point_triangle_distance(const Eigen::Vector3d& p, const Eigen::Vector3d& a,
                                             const Eigen::Vector3d& b, const Eigen::Vector3d& c);

}  // namespace arpent::evaluation
