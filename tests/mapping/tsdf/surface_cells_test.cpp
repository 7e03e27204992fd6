// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Planes of cells against a dense least-squares solver, and the whole integration against a naive
// one that asks every voxel of a box.
#include "mapping/tsdf/surface_cells.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "mapping/tsdf/storage.h"

namespace arpent::mapping {
namespace {

const PinholeCamera kCamera{160, 128, 94, 94, 79.5, 63.5};
constexpr double kNear = 0.3, kFar = 5.0;

stereo::DepthMap empty() {
  return {kCamera, cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.0F),
          cv::Mat1f(kCamera.height_px, kCamera.width_px, 0.0F)};
}

/// A slanted wall with a round post in front of it, noisy, with holes.
stereo::DepthMap cluttered(int seed) {
  stereo::DepthMap depth = empty();
  std::mt19937 random(static_cast<unsigned>(seed));
  std::normal_distribution<double> normal;
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, 0.2, 1).normalized();
  for (int v = 0; v < kCamera.height_px; ++v) {
    for (int u = 0; u < kCamera.width_px; ++u) {
      const Eigen::Vector3d ray = kCamera.unproject(u, v, 1.0);
      double z = 3.0 / n.dot(ray);
      if (std::abs(u - 70) < 30) z = 1.5 - 0.3 * std::sqrt(1 - std::pow((u - 70) / 30.0, 2));
      const double sigma = 2e-3 * z * z;
      z += sigma * normal(random);
      if (random() % 17 == 0 || z < kNear || z > kFar) continue;
      depth.depth_m(v, u) = static_cast<float>(z);
      depth.sigma_m(v, u) = static_cast<float>(sigma);
    }
  }
  return depth;
}

TEST(SurfaceCells, PlanesAreThoseOfADenseSolver) {
  const stereo::DepthMap depth = cluttered(1);
  const SurfaceCells cells = fit_surface_cells(depth, kNear, kFar);
  int compared = 0;
  for (int cv = 1; cv + 1 < cells.rows; ++cv) {
    for (int cu = 1; cu + 1 < cells.cols; ++cu) {
      if (cells.kinds[cells.at(cu, cv)] != CellKind::kPlane) continue;
      std::vector<Eigen::Vector4d> rows;  // u, v, 1, inverse depth
      for (int v = 4 * cv - 4; v < 4 * cv + 8; ++v) {
        for (int u = 4 * cu - 4; u < 4 * cu + 8; ++u) {
          if (depth.depth_m(v, u) > 0) rows.emplace_back(u, v, 1, 1.0 / depth.depth_m(v, u));
        }
      }
      Eigen::MatrixXd A(rows.size(), 3);
      Eigen::VectorXd b(rows.size());
      for (std::size_t i = 0; i < rows.size(); ++i) {
        A.row(static_cast<Eigen::Index>(i)) = rows[i].head<3>().transpose();
        b(static_cast<Eigen::Index>(i)) = rows[i](3);
      }
      const Eigen::Vector3d x = A.colPivHouseholderQr().solve(b);
      const double u = 4 * cu + 1.5, v = 4 * cv + 1.5;
      const double z = 1 / x.dot(Eigen::Vector3d(u, v, 1));
      const Eigen::Vector3d p = kCamera.unproject(u, v, z);
      const Cell& plane = cells.planes[cells.at(cu, cv)];
      EXPECT_NEAR(plane.nx * p.x() + plane.ny * p.y() + plane.nz * p.z() + plane.offset_m, 0, 1e-4);
      EXPECT_NEAR(Eigen::Vector3f(plane.nx, plane.ny, plane.nz).norm(), 1, 1e-5);
      EXPECT_GT(plane.offset_m, 0) << "the camera is on the positive side";
      ++compared;
    }
  }
  EXPECT_GT(compared, 300);
}

/// What the header of TsdfMap promises, voxel by voxel in doubles, without blocks to leave out.
Voxel ask_naively(const stereo::DepthMap& depth, const SurfaceCells& cells, const Eigen::Vector3d& p, double voxel_m,
                  double truncation_m) {
  if (p.z() < 0.05) return {};
  const double u = kCamera.fx_px * p.x() / p.z() + kCamera.cx_px + 0.5;
  const double v = kCamera.fy_px * p.y() / p.z() + kCamera.cy_px + 0.5;
  if (u < 0 || v < 0 || u >= kCamera.width_px || v >= kCamera.height_px) return {};
  const std::size_t at = cells.at(static_cast<int>(u) / kCellPx, static_cast<int>(v) / kCellPx);
  double distance = 0;
  switch (cells.kinds[at]) {
    case CellKind::kNone:
      return {};
    case CellKind::kEdge: {
      const double z = depth.depth_m(static_cast<int>(v), static_cast<int>(u));
      if (z < kNear || z > kFar) return {};
      distance = z - p.z();
      if (distance < -voxel_m) return {};
      break;
    }
    case CellKind::kPlane: {
      const Cell& c = cells.planes[at];
      const Eigen::Vector3d n(c.nx, c.ny, c.nz);
      distance = n.dot(p) + c.offset_m;
      if (distance < -truncation_m) return {};
      const double behind = p.z() - p.z() * c.offset_m / -n.dot(p);
      if (distance < 0 && behind > 4 * truncation_m) return {};
    }
  }
  double weight = 1 / p.squaredNorm();
  if (distance < -voxel_m / 2) weight *= (truncation_m + distance) / (truncation_m - voxel_m / 2);
  return {static_cast<float>(std::min(distance, truncation_m)), static_cast<float>(weight)};
}

TEST(TsdfMap, TheFastIntegrationSaysWhatANaiveOneSays) {
  TsdfParams params;
  params.voxel_m = 0.1;
  TsdfMap map(params);
  const stereo::DepthMap depth = cluttered(3);
  Pose T_map_cam(Eigen::Translation3d(0.33, -0.21, 0.4) *
                 Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 0.5).normalized()));
  ASSERT_TRUE(map.integrate(depth, T_map_cam));
  const SurfaceCells cells = fit_surface_cells(depth, kNear, kFar);
  const Pose T_cam_map = T_map_cam.inverse();
  int seen = 0, differing = 0;
  for (int z = -60; z < 70; ++z) {
    for (int y = -60; y < 60; ++y) {
      for (int x = -60; x < 70; ++x) {
        const VoxelIndex index(x, y, z);
        const Voxel expected = ask_naively(depth, cells, T_cam_map * map.centre_m(index), 0.1, 0.3);
        const auto voxel = map.voxel(index);
        seen += expected.weight > 0 ? 1 : 0;
        const Voxel got = voxel.value_or(Voxel{});
        // Rounding decides which pixel a voxel on a pixel's border asks: a handful may differ.
        if (std::abs(got.weight - expected.weight) > 1e-4F * std::max(expected.weight, 1.0F) ||
            std::abs(got.distance_m - expected.distance_m) > 1e-3F) {
          ++differing;
        }
      }
    }
  }
  EXPECT_GT(seen, 5000);
  EXPECT_LE(differing, seen / 1000);
}

}  // namespace
}  // namespace arpent::mapping
