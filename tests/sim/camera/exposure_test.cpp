// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/camera/exposure.h"

#include <gtest/gtest.h>

#include "tests/sim/camera/scenes.h"

namespace arpent::sim {
namespace {

/// A wall of 0.45 in a light of `light` and its picture, until the controller has settled.
double settled_level(double light, AutoExposure& control) {
  World world = wall_world(2, plain(0.45));
  world.lighting.mean = light;
  const Renderer renderer(world);
  const CameraModel camera(half_camera());
  double level = 0;
  for (int i = 0; i < 12; ++i) {
    CameraShot shot;
    shot.exposure_s = control.exposure_s();
    shot.gain = control.gain();
    const cv::Mat1b image = renderer.render(camera, looking_along_x({0, 0, 0}), shot).image;
    control.update(image);
    level = cv::mean(image)[0];
  }
  return level;
}

TEST(Exposure, SettlesAtTheTargetInBrightAndDimLight) {
  AutoExposure bright, dim;
  EXPECT_NEAR(settled_level(4, bright), 100, 5);
  EXPECT_EQ(bright.gain(), 1);
  EXPECT_NEAR(settled_level(0.25, dim), 100, 5);
  EXPECT_EQ(dim.exposure_s(), 0.008) << "longer exposures would blur";
  EXPECT_GT(dim.gain(), 1.2);
}

TEST(Exposure, InTheDarkItStopsAtItsLimits) {
  AutoExposure control;
  for (int i = 0; i < 100; ++i) control.update(cv::Mat1b(8, 8, std::uint8_t{0}));
  EXPECT_EQ(control.exposure_s(), 0.008);
  EXPECT_DOUBLE_EQ(control.gain(), 8);
}

}  // namespace
}  // namespace arpent::sim
