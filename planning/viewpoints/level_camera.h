// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The robot's stereo camera as planning sees it: level, at a fixed height, looking ahead, with the frustum in which
// depth exists: what both images show, within the range of depth.
#pragma once

#include <Eigen/Core>

#include "common/camera.h"
#include "common/pose2.h"

namespace arpent::planning {

struct LevelCamera {
  /// Slopes (tangents) of the image borders seen from the left camera, all positive.
  double left_slope = 0, right_slope = 0, up_slope = 0, down_slope = 0;
  double baseline_m = 0;
  double min_range_m = 0.3, max_range_m = 5.0;         ///< of depth, along the optical axis
  Eigen::Vector3d p_body_m = Eigen::Vector3d::Zero();  ///< left camera in the body's frame, whose z = 0 is the ground

  /// Middle of the pair on the ground, in the body's frame.
  [[nodiscard]] Eigen::Vector2d centre_body_m() const { return {p_body_m.x(), p_body_m.y() - baseline_m / 2}; }
  /// Left camera in the map, for a body on the ground z = 0.
  [[nodiscard]] Eigen::Vector3d position_m(const Pose2& pose) const;
  /// The body's pose whose pair stands at `centre_m` and looks along `yaw_rad`.
  [[nodiscard]] Pose2 body_at(const Eigen::Vector2d& centre_m, double yaw_rad) const;
  /// Depth along the optical axis from which a point this far above (or below) the camera is inside the vertical view.
  [[nodiscard]] double stand_off_for_height_m(double above_camera_m) const;
};

/// A pose of the camera, ready to be asked about many points.
class CameraView {
 public:
  /// Keeps a reference to the camera.
  CameraView(const LevelCamera& camera, const Pose2& pose);
  [[nodiscard]] const Eigen::Vector3d& position_m() const { return position_m_; }
  /// Depth along the optical axis.
  [[nodiscard]] double depth_m(const Eigen::Vector3d& p_map_m) const {
    return forward_.dot(p_map_m.head<2>() - position_m_.head<2>());
  }
  /// Whether both images show the point within range, nothing in between.
  [[nodiscard]] bool contains(const Eigen::Vector3d& p_map_m) const {
    const Eigen::Vector2d d = p_map_m.head<2>() - position_m_.head<2>();
    const double depth = forward_.dot(d);
    if (!(depth >= camera_.min_range_m && depth <= camera_.max_range_m)) return false;
    const double right = forward_.y() * d.x() - forward_.x() * d.y();
    if (right > camera_.right_slope * depth || right - camera_.baseline_m < -camera_.left_slope * depth) return false;
    const double up = p_map_m.z() - position_m_.z();
    return up <= camera_.up_slope * depth && up >= -camera_.down_slope * depth;
  }

 private:
  const LevelCamera& camera_;
  Eigen::Vector3d position_m_;
  Eigen::Vector2d forward_;
};

/// `T_body_cam` is the rectified left camera's pose on the body. Throws InputError if it does not look level along the
/// body's x axis (within 2 degrees) or the ranges make no sense.
[[nodiscard]] LevelCamera make_level_camera(const RectifiedStereo& stereo, const Pose& T_body_cam, double min_range_m,
                                            double max_range_m);

}  // namespace arpent::planning
