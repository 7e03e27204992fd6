// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Wheels and mounting of the camera as found from a drive: for people (sentences, HTML page), for scripts (JSON) and
// for the stack (blocks of the robot and the rig file). What the drive did not show keeps its old value everywhere.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/calibrate/drive_log.h"

namespace arpent::tools {

enum class DriveSubject { kWheels, kBody };

/// Scales and track for the robot file.
[[nodiscard]] BaseGeometry calibrated_geometry(const DriveLog& drive, const calib::DriveCalibration& found);
/// The rig with its camera where the drive says that it is.
[[nodiscard]] RigConfig calibrated_rig(const DriveLog& drive, const calib::DriveCalibration& found);

/// `base: {track_m, left_scale, right_scale}`, to be put into the robot file; intervals as comments.
[[nodiscard]] std::string to_wheels_yaml(const DriveLog& drive, const calib::DriveCalibration& found);
/// Lines for the terminal; intervals hold 95 %.
[[nodiscard]] std::string summarize(DriveSubject subject, const DriveLog& drive, const calib::DriveCalibration& found);
[[nodiscard]] nlohmann::json to_json(DriveSubject subject, const DriveLog& drive, const calib::DriveCalibration& found);
/// `folder`/wheels.yaml or rig.yaml, and report.html. Throws InputError.
void write_drive_files(DriveSubject subject, const DriveLog& drive, const calib::DriveCalibration& found,
                       const std::filesystem::path& folder);

}  // namespace arpent::tools
