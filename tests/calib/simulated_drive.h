// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A drive of a simulated robot (sim/robot, drivers/base) as wheels and camera see it, for tests and bench of
// calib/drive.
#pragma once

#include <cstdint>

#include "calib/drive.h"

namespace arpent::calib {

struct DriveTruth {
  double left_scale = 1.015, right_scale = 0.99, track_m = 0.40;
  double time_offset_s = 0.033;
  /// T_body_filed: a camera that sits 2 degrees and 3 cm from where its file says.
  double mount_x_m = 0.03, mount_y_m = -0.02, mount_yaw_rad = 0.035, mount_pitch_rad = 0.01;
};

/// Two minutes of arcs, turns and straight ways, or of one circle. kSteps: odometry with the simulator's noise. kPoses:
/// the tag cube, 4 mm and 2 mrad.
[[nodiscard]] DriveInput simulate_drive(const DriveTruth& truth, CameraMotion motion, std::uint32_t seed,
                                        bool circle = false);

/// Errors of a calibration, by DriveParameter; 0 for the scale of steps.
[[nodiscard]] Eigen::Matrix<double, kDriveParameters, 1> error_of(const DriveCalibration& found,
                                                                  const DriveTruth& truth);

}  // namespace arpent::calib
