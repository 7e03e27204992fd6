// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Stereo visual odometry after eVO (thesis Sect. 1.2.2): corners tracked by Lucas-Kanade from frame to frame, 3D points
// triangulated at keyframes, P3P in RANSAC against the last keyframe, nonlinear refinement of the reprojection in
// (u_left, v, u_right). It works on rectified grey pairs and knows nothing of wheels, gyros or the bus.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "common/camera.h"
#include "common/config/fields.h"
#include "common/geometry.h"
#include "common/time.h"
#include "perception/odometry/stereo_projection.h"

namespace arpent::odometry {

enum class Status : std::int8_t {
  kOk = 0,
  kDegraded = 1,  ///< a pose is given, from few or poorly spread points
  kLost = 2,      ///< no pose from this pair: the last one is repeated; tracking restarts from it by itself
};

struct OdometryParams {
  int seed = 1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("seed", self.seed, "seed of the random sampling", config::at_least(0));
  }
};

struct Estimate {
  Time stamp;
  Pose T_odom_cam = Pose::Identity();  ///< left camera in the odometry frame (= the first pair's left camera)
  /// Covariance of `local(true pose, estimate)` *accumulated since the start*, tangent (translation [m], rotation
  /// [rad]) in the camera frame.
  Matrix6d covariance = Matrix6d::Zero();
  /// Covariance of the motion since the last pair, same tangent.
  Matrix6d step_covariance = Matrix6d::Zero();
  Status status = Status::kLost;
  std::string reason;  ///< why DEGRADED or LOST; empty when OK
  int tracked = 0;     ///< points tracked into this pair
  int inliers = 0;     ///< points that agree with the pose
  bool keyframe = false;
};

class StereoOdometry {
 public:
  /// Throws InputError for a camera or parameters that cannot be used.
  StereoOdometry(const RectifiedStereo& stereo, const OdometryParams& params);
  ~StereoOdometry();
  StereoOdometry(StereoOdometry&&) noexcept;
  StereoOdometry& operator=(StereoOdometry&&) noexcept;

  /// Takes the next pair (8-bit, the camera's size) and returns exactly one estimate. The first pair has the identity
  /// pose and status OK if it has enough points. Deterministic. `T_last_now`: the camera now seen from the last pair,
  /// as wheels and gyro have it: where points are looked for first.
  [[nodiscard]] Estimate track(Time stamp, const cv::Mat1b& left, const cv::Mat1b& right,
                               const std::optional<Pose>& T_last_now = std::nullopt);
  /// What all disparities were found to be short of so far: a calibration that is good keeps it below 0.3 px.
  [[nodiscard]] DisparityOffset disparity_offset() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::odometry
