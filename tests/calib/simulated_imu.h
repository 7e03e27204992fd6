// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A camera with an inertial unit moved by hand, every number known: sums of sines whose derivatives are exact. For
// tests and bench of calib/camera_imu.
#pragma once

#include <cstdint>

#include "calib/camera_imu.h"

namespace arpent::calib {

struct ImuTruth {
  Pose T_cam_imu = Pose::Identity();
  double time_offset_s = 0.018;

  ImuTruth();
};

enum class Excitation { kAllAxes, kLevel };

/// Twenty seconds; readings at 200 Hz, the camera at 10 Hz. kPoses: a board, 2 mm and 1 mrad; kSteps: odometry, 1 mm
/// and 0.5 mrad a step. kLevel: on the ground, turns about the vertical alone. `camera_noise` scales what is said of
/// the camera.
[[nodiscard]] CameraImuInput simulate_imu(const ImuTruth& truth, CameraMotion motion, Excitation excitation,
                                          std::uint32_t seed, double camera_noise = 1);

[[nodiscard]] double rotation_error_rad(const CameraImuCalibration& found, const ImuTruth& truth);

}  // namespace arpent::calib
