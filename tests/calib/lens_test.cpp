// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/lens.h"

#include <gtest/gtest.h>

#include "sim/camera/lens.h"
#include "tests/calib/simulated_views.h"

namespace arpent::calib {
namespace {

TEST(CalibLens, ProjectsAsTheSimulatorDoesAndComesBack) {
  for (const auto model : {DistortionModel::kRadialTangential, DistortionModel::kEquidistant}) {
    const RawCamera camera = simulated_rig(model).cameras[0];
    const LensParameters lens = to_parameters(camera);
    for (double x = -0.7; x <= 0.7; x += 0.1) {
      for (double y = -0.5; y <= 0.5; y += 0.1) {
        const Eigen::Vector3d p = 2.0 * Eigen::Vector3d(x, y, 1);
        Eigen::Vector2d px;
        ASSERT_TRUE(project(model, lens.data(), p.data(), px.data()));
        const Eigen::Vector2d plane = sim::distort(camera, {x, y});
        EXPECT_NEAR(px.x(), camera.pinhole.fx_px * plane.x() + camera.pinhole.cx_px, 1e-9);
        EXPECT_NEAR(px.y(), camera.pinhole.fy_px * plane.y() + camera.pinhole.cy_px, 1e-9);
        const auto back = unproject(camera, px);
        ASSERT_TRUE(back);
        EXPECT_LT((*back - Eigen::Vector2d(x, y)).norm(), 1e-9);
      }
    }
  }
}

TEST(CalibLens, SeesNothingBehindItself) {
  const RawCamera camera = simulated_rig(DistortionModel::kRadialTangential).cameras[0];
  const LensParameters lens = to_parameters(camera);
  const Eigen::Vector3d behind(0.1, 0.1, -1);
  Eigen::Vector2d px;
  EXPECT_FALSE(project(camera.distortion, lens.data(), behind.data(), px.data()));
}

}  // namespace
}  // namespace arpent::calib
