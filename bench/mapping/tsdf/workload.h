// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The workload of bench `tsdf`, the same on which other mapping libraries were measured: a room of 21 x 14 x 2 m with
// pillars and boxes, a closed path of 150 poses, noisy depth images. All of it is analytic, and independent of sim/.
#pragma once

#include <Eigen/Core>
#include <random>
#include <vector>

#include "common/geometry.h"
#include "perception/stereo/depth_map.h"

namespace arpent::bench {

/// Vertical cylinder through floor and ceiling.
struct Pillar {
  Eigen::Vector2d centre;
  double radius;
};

/// Box turned about the vertical.
struct YawedBox {
  Eigen::Vector3d centre;
  Eigen::Vector3d half;
  double yaw_rad;

  [[nodiscard]] Eigen::Vector3d to_own(const Eigen::Vector3d& direction) const;
};

/// Everything is in the scene's frame unless it says "map": the map's lattice is turned and shifted against the walls.
class Room {
 public:
  Room();

  [[nodiscard]] const Pose& T_map_scene() const { return T_map_scene_; }
  /// Range along the unit-z ray `direction` (z in the camera is 1) from a point inside.
  [[nodiscard]] double cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;
  /// Distance to the nearest surface.
  [[nodiscard]] double distance(const Eigen::Vector3d& p) const;
  /// Points every `spacing_m` on all surfaces that bound free space.
  [[nodiscard]] std::vector<Eigen::Vector3d> sample_surface(double spacing_m) const;

 private:
  [[nodiscard]] bool inside_obstacle(const Eigen::Vector3d& p) const;

  Eigen::Vector3d size_{21, 14, 2};
  std::vector<Pillar> pillars_;
  std::vector<YawedBox> boxes_;
  Pose T_map_scene_;
};

inline constexpr int kPoses = 150;
[[nodiscard]] PinholeCamera workload_camera();
/// Pose of the camera at step i of the path.
[[nodiscard]] Pose T_scene_cam_at(int i);

/// Renders the depth images one after the other: their noise comes from one generator.
class DepthSequence {
 public:
  explicit DepthSequence(const Room& room) : room_(room) {}
  [[nodiscard]] stereo::DepthMap next();

 private:
  const Room& room_;
  std::mt19937_64 random_{42};
  int i_ = 0;
};

/// Of `samples`, those that some pose sees, within range and not hidden.
[[nodiscard]] std::vector<Eigen::Vector3d> keep_observed(const Room& room, const std::vector<Eigen::Vector3d>& samples);

}  // namespace arpent::bench
