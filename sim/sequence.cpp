// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/sequence.h"

#include <cmath>
#include <numbers>

namespace arpent::sim {
namespace {

constexpr double kSpeedMps = 0.5;

/// The drive at arc length s: a circle of 1.7 m around (4.4, 3.5), counter-clockwise, from its leftmost point, the body
/// looking along the path and swaying gently so that walls and obstacle come into view.
Pose pose_at(double s_m) {
  constexpr double kRadiusM = 1.7;
  const double angle = std::numbers::pi + s_m / kRadiusM;
  const double yaw = angle + std::numbers::pi / 2 + 0.35 * std::sin(1.1 * s_m);
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(4.4 + kRadiusM * std::cos(angle), 3.5 + kRadiusM * std::sin(angle), 0);
  return pose;
}

}  // namespace

std::vector<DrivePose> make_arena_drive(double duration_s, double rate_hz, Time start) {
  std::vector<DrivePose> drive;
  const int count = static_cast<int>(std::floor(duration_s * rate_hz)) + 1;
  for (int i = 0; i < count; ++i) {
    const double t = i / rate_hz;
    drive.push_back({start + from_seconds(t), pose_at(kSpeedMps * t)});
  }
  return drive;
}

RenderedPair render_pair(const Scene& scene, const RectifiedStereo& stereo, const Pose& T_body_cam,
                         const DrivePose& pose, std::uint64_t number, const CameraNoise& noise) {
  const Pose T_world_left = pose.T_world_body * T_body_cam;
  const Pose T_world_right = T_world_left * Eigen::Translation3d(stereo.baseline_m, 0, 0);
  const Rendering left = render(scene, stereo.camera, T_world_left, noise, 2 * number);
  const Rendering right = render(scene, stereo.camera, T_world_right, noise, 2 * number + 1);
  return {pose, left.image, right.image, left.depth_m};
}

}  // namespace arpent::sim
