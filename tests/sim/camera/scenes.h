// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Small worlds and cameras for the tests of the simulated camera.
#pragma once

#include "sim/camera/renderer.h"

namespace arpent::sim {

/// A wall 10 x 10 m at x = `distance_m`, seen from the origin along x, with a lamp behind the camera.
inline World wall_world(double distance_m, const TextureSpec& texture) {
  World world;
  world.region = {{-1, -6, -6}, {distance_m + 1, 6, 6}};
  world.textures.push_back(texture);
  world.surfaces.push_back({PlaneShape{{distance_m, 5, -5}, {0, -10, 0}, {0, 0, 10}}, 0, 0});
  world.lighting.lamps.push_back({{-100, 0, 0}, 1.0});
  return world;
}

inline TextureSpec plain(double mean) {
  TextureSpec texture;
  texture.mean = mean;
  texture.stains = 0;
  return texture;
}

/// Camera axes at a position, looking along x.
inline Pose looking_along_x(const Eigen::Vector3d& position_m) {
  Pose T = Pose::Identity();
  T.linear() = R_body_from_camera_axes();
  T.translation() = position_m;
  return T;
}

inline RawCamera half_camera() {
  RawCamera camera;
  camera.pinhole = {320, 256, 188.5, 188.5, 159.5, 127.5};
  return camera;
}

inline SensorParams ideal() {
  return {0, 0, 0};
}

}  // namespace arpent::sim
