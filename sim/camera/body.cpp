// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/body.h"

#include <numbers>

namespace arpent::sim {
namespace {

constexpr int kNoPattern = -1;
constexpr int kWheelSides = 12;

}  // namespace

void add_robot(SurfaceMesh& mesh, const Pose& T_world_body) {
  const auto at = [&](double x, double y, double z) { return T_world_body * Eigen::Translation3d(x, y, z); };
  add_box(mesh, at(0, 0, 0.18), {0.60, 0.32, 0.16}, kNoPattern, 0.32F);
  add_box(mesh, at(-0.10, 0, 0.275), {0.24, 0.20, 0.03}, kNoPattern, 0.70F);  // lid
  for (const double x : {-0.20, 0.20}) {
    for (const double side : {-1.0, 1.0}) {
      // A wheel's axis points outwards.
      const Pose T =
          at(x, side * 0.16, 0.10) * Eigen::AngleAxisd(-side * std::numbers::pi / 2, Eigen::Vector3d::UnitX());
      add_prism(mesh, T, 0.10, 0.07, kWheelSides, kNoPattern, 0.06F);
    }
  }
  add_box(mesh, at(0.18, 0, 0.31), {0.04, 0.04, 0.12}, kNoPattern, 0.45F);  // mast
  add_box(mesh, at(0.18, 0, 0.40), {0.04, 0.34, 0.06}, kNoPattern, 0.12F);  // bar
  for (const double y : {-0.13, 0.13}) add_box(mesh, at(0.205, y, 0.40), {0.01, 0.03, 0.03}, kNoPattern, 0.55F);
}

}  // namespace arpent::sim
