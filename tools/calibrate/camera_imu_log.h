// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `calibrate camera-imu`: the inertial unit and the left camera from the log of an excited motion, and the result as
// files: Kalibr's camchain-imucam.yaml, imu_process' mounting, a report.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "calib/camera_imu.h"
#include "tools/calibrate/motion_log.h"

namespace arpent::tools {

struct CameraImuSources {
  std::filesystem::path log;
  std::filesystem::path rig;     ///< file instead of what the log brings along
  std::filesystem::path target;  ///< the board that was shown; empty: the odometry's motion is used
};

struct CameraImuLog {
  calib::CameraImuInput input;  ///< camera: the left one
  StereoCalibration rig;
  std::string camera;  ///< where the camera's motion is from, in words
};

/// Throws InputError: no readings, no camera, clocks that go back, a board that is not seen.
[[nodiscard]] CameraImuLog load_camera_imu(const CameraImuSources& sources, const Progress& progress);

/// The rig with T_cam_imu and timeshift_cam_imu. What was not observed is left out.
[[nodiscard]] std::string to_imucam_yaml(const CameraImuLog& log, const calib::CameraImuCalibration& found);
/// `mount_quaternion_wxyz` for imu_process, to be turned before the one that the log was made with.
[[nodiscard]] std::string to_mount_yaml(const CameraImuLog& log, const calib::CameraImuCalibration& found);
/// Lines for the terminal; intervals hold 95 %.
[[nodiscard]] std::string summarize(const CameraImuLog& log, const calib::CameraImuCalibration& found);
[[nodiscard]] nlohmann::json to_json(const CameraImuLog& log, const calib::CameraImuCalibration& found);
/// `folder`/camchain-imucam.yaml, imu_mount.yaml, report.html. Throws InputError.
void write_camera_imu_files(const CameraImuLog& log, const calib::CameraImuCalibration& found,
                            const std::filesystem::path& folder);

}  // namespace arpent::tools
