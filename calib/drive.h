// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Calibrates a differential drive against a camera that rides on it: scales of both sides, track, delay between the two
// clocks, and where the camera sits, all from one drive on level ground (after Censi et al. 2013, with the delay and
// the noise of the wheels added). Camera motion comes as steps (odometry) or as poses in a fixed frame (tags). What the
// drive does not show stays where it was, with the deviation of what is thinkable, and is called unobserved.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "common/geometry.h"

namespace arpent::calib {

/// Ways of the two sides since some moment, by the scales that the robot has now.
struct WheelWays {
  double t_s = 0;
  double left_m = 0;
  double right_m = 0;
};

/// The body as the camera sees it go, by the mounting that the rig file has now.
struct CameraPose {
  double t_s = 0;
  Pose T_ref_body = Pose::Identity();
  /// Of (x, y, yaw) in body axes: of the pose, or of the step from the pose before.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  /// Whether the way here from the pose before is known: not after odometry was lost.
  bool linked = true;
};

/// Deviations to either side that make an interval of 95 %.
inline constexpr double kConfidence = 1.96;

enum class CameraMotion { kSteps, kPoses };

struct DriveInput {
  std::vector<WheelWays> wheels;   ///< by time
  std::vector<CameraPose> camera;  ///< by time
  CameraMotion motion = CameraMotion::kSteps;
  double track_m = 0;  ///< to start from
  /// Standard deviation of the scale of camera steps: one error for the whole drive, which no step's covariance holds.
  double step_scale_deviation = 0.005;
  /// Poses whose tilt was measured, not assumed to be level.
  bool tilt_measured = true;
};

/// Places in DriveCalibration::covariance.
enum DriveParameter {
  kLeftScale,
  kRightScale,
  kTrack,
  kTimeOffset,
  kMountX,
  kMountY,
  kMountYaw,
  kStepScale,
  kDriveParameters
};

struct DriveCalibration {
  double left_scale = 1;  ///< true way over the one that the log says
  double right_scale = 1;
  double track_m = 0;
  double time_offset_s = 0;  ///< wheels' time of a moment, less the camera's
  /// Takes what the rig file calls body to the body that the wheels turn about: T_body_cam = correction * the file's.
  /// Its height is 0: a drive on level ground does not show it.
  Pose T_body_filed = Pose::Identity();
  double step_scale = 1;  ///< camera's steps over the true ones
  /// Whether roll and pitch of T_body_filed were seen: only poses in a frame whose z axis is vertical show them.
  bool tilt_observed = false;
  double tilt_deviation_rad = 0;
  Eigen::Matrix<double, kDriveParameters, kDriveParameters> covariance;
  double reduced_chi2 = 0;  ///< the covariance of what was measured is scaled by it
  double driven_m = 0, turned_rad = 0;
  std::size_t steps = 0;

  [[nodiscard]] double deviation(DriveParameter parameter) const { return std::sqrt(covariance(parameter, parameter)); }
  /// Whether it is known well enough to be worth having.
  [[nodiscard]] bool observed(DriveParameter parameter) const;
};

/// Throws InputError with the reason if the drive cannot be used: no motion, no turns, clocks apart, swapped or
/// reversed wheels, motion of another robot. Deterministic.
[[nodiscard]] DriveCalibration calibrate_drive(const DriveInput& input);

/// What the drive did not show, and what would, a sentence each. Never empty: level ground hides the camera's height.
[[nodiscard]] std::vector<std::string> unobserved(const DriveCalibration& found);

}  // namespace arpent::calib
