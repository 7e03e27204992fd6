// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where an inertial unit sits next to a camera, and how far their clocks are apart, from one excited motion: a least
// squares problem over the camera's poses, speeds, biases and gravity, with the readings integrated between the
// camera's moments (Forster et al. 2017) and the delay as a parameter (Furgale et al. 2013). What the motion does not
// show is named.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "calib/drive.h"
#include "common/geometry.h"

namespace arpent::calib {

struct ImuSample {
  double t_s = 0;
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  ///< specific force
};

struct CameraSample {
  double t_s = 0;
  Pose T_ref_cam = Pose::Identity();
  /// (translation [m], rotation [rad]) in camera axes: of the pose, or of the step from the sample before.
  Matrix6d covariance = Matrix6d::Identity();
  bool linked = true;  ///< whether the step from the sample before is known
};

struct CameraImuInput {
  std::vector<ImuSample> imu;        ///< by time
  std::vector<CameraSample> camera;  ///< by time; of steps, the longest linked part is used
  CameraMotion motion = CameraMotion::kPoses;
  Pose T_cam_imu = Pose::Identity();  ///< what is believed: kept where the motion shows nothing else
  double gyro_noise_radpsrthz = 2e-3;
  double accelerometer_noise_mps2rthz = 2e-2;
};

/// Places in CameraImuCalibration::covariance: a small turn R_cam_imu * exp(turn), t_cam_imu, the clocks' offset.
inline constexpr int kMountTurn = 0, kMountPlace = 3, kImuTimeOffset = 6, kCameraImuParameters = 7;

/// Deviations beyond which a turn [rad], a place or an offset counts as not observed.
inline constexpr double kTurnWorth = 0.01, kPlaceWorthM = 0.02, kOffsetWorthS = 0.003;

struct CameraImuCalibration {
  Pose T_cam_imu = Pose::Identity();
  double time_offset_s = 0;  ///< the inertial unit's time of a moment, less the camera's (Kalibr's timeshift_cam_imu)
  Eigen::Vector3d gyro_bias_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_bias_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gravity_ref_mps2 = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, kCameraImuParameters, kCameraImuParameters> covariance;
  double reduced_chi2 = 0;  ///< the covariance of what was measured is scaled by it
  double turned_rad = 0, duration_s = 0;
  std::size_t steps = 0;

  [[nodiscard]] double deviation(int parameter) const { return std::sqrt(covariance(parameter, parameter)); }
  /// Deviation along the worst of the three axes, and that axis: of the turn in the unit's axes, of the place in the
  /// camera's.
  [[nodiscard]] double worst_deviation(int first, Eigen::Vector3d* axis = nullptr) const;
  [[nodiscard]] bool rotation_observed() const;
  [[nodiscard]] bool place_observed() const;
  [[nodiscard]] bool time_offset_observed() const;
};

/// Throws InputError with the reason if the log cannot be used: too short, no turning, clocks apart, another robot's
/// unit. Deterministic.
[[nodiscard]] CameraImuCalibration calibrate_camera_imu(const CameraImuInput& input);

/// What the motion did not show, and what would, a sentence each.
[[nodiscard]] std::vector<std::string> unobserved(const CameraImuCalibration& found);

}  // namespace arpent::calib
