// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures for the stereo tests.
#pragma once

#include <cstdint>
#include <opencv2/imgproc.hpp>

#include "sim/scene.h"

namespace arpent::stereo {

/// Smoothed noise: rich, aperiodic texture.
inline cv::Mat1b texture(int rows, int cols, int seed) {
  cv::Mat1b image(rows, cols);
  cv::RNG(static_cast<std::uint64_t>(seed)).fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {5, 5}, 1.0);
  return image;
}

/// The test arena as a stereo camera at half our rig's resolution sees it, with the left view's exact depth.
struct ArenaPair {
  PinholeCamera camera{320, 256, 188.5, 188.5, 159.5, 127.5};
  double baseline_m = 0.26;
  sim::Rendering left, right;

  ArenaPair() {
    const sim::Scene scene = sim::make_test_arena();
    Pose T_world_left(R_body_from_camera_axes());
    T_world_left.translation() = Eigen::Vector3d(1.5, 2.0, 0.4);
    left = sim::render(scene, camera, T_world_left, {}, 1);
    right = sim::render(scene, camera, T_world_left * Eigen::Translation3d(baseline_m, 0, 0), {}, 2);
  }
  [[nodiscard]] double disparity_px(int v, int u) const { return baseline_m * camera.fx_px / left.depth_m(v, u); }
};

}  // namespace arpent::stereo
