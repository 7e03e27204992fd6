// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A small world of planes, boxes and cylinders with textured surfaces, and what a camera sees of it: grey images with
// sensor noise, and exact depth. It stands in for cameras where there are none; the truth is known to the last digit.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "common/camera.h"
#include "common/mesh.h"

namespace arpent::sim {

/// How a surface looks: its mean grey level, the contrast of its texture (standard deviation, grey levels), and which
/// part of the texture it shows.
struct Surface {
  double mean = 120;
  double contrast = 25;
  double offset_m = 0;
};

/// A box with its axis vertical: centre, half-size, yaw. `inside_out`: a room, seen from within.
struct Box {
  Eigen::Vector3d centre_m;
  Eigen::Vector3d half_m;
  double yaw_rad = 0;
  Surface surface;
  bool inside_out = false;
  bool open_top = false;  ///< of a room: no ceiling
};

/// A vertical cylinder standing from z = 0 to height_m.
struct Cylinder {
  Eigen::Vector2d centre_m;
  double radius_m = 0.3;
  double height_m = 2;
  Surface surface;
};

struct Scene {
  std::vector<Box> boxes;
  std::vector<Cylinder> cylinders;
};

/// A room of 8 x 7 x 2 m without ceiling, with mats on the walls and an obstacle in the middle: DESIGN's test arena.
[[nodiscard]] Scene make_test_arena();

struct CameraNoise {
  double read_levels = 1.0;   ///< Gaussian, standard deviation
  double shot_levels = 0.06;  ///< times the square root of the level
  double vignetting = 0.15;   ///< darkening in the corners
};

struct Rendering {
  cv::Mat1b image;
  cv::Mat1f depth_m;  ///< along the optical axis, 0 where nothing is hit
};

/// `seed` makes the noise; the same arguments give the same bytes. Textures are filtered to the pixel's footprint.
[[nodiscard]] Rendering render(const Scene& scene, const PinholeCamera& camera, const Pose& T_world_cam,
                               const CameraNoise& noise, std::uint64_t seed);

/// The scene's surface as triangles, normals towards free space.
[[nodiscard]] TriangleMesh to_mesh(const Scene& scene);

}  // namespace arpent::sim
