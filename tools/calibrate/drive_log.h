// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `calibrate wheels` and `calibrate body`: what calib/drive needs from the log of a drive.
#pragma once

#include <filesystem>
#include <string>

#include "calib/drive.h"
#include "tools/calibrate/motion_log.h"

namespace arpent::tools {

struct DriveSources {
  std::filesystem::path log;
  std::filesystem::path robot, rig, tags;  ///< files instead of what the log brings along
  std::string by = "auto";                 ///< auto, tags or odometry: where the camera's motion is from
};

struct DriveLog {
  calib::DriveInput input;
  BaseGeometry geometry;  ///< that the log's ways were made with
  double ticks_per_m = 0;
  RigConfig rig;
  std::string camera;  ///< where the camera's motion is from, in words
  double duration_s = 0;
};

/// Tags are taken where they are seen during most of the drive. They and odometry are read from the log, or made from
/// its pictures if it has none. Throws InputError: no wheels, no camera, clocks that go back.
[[nodiscard]] DriveLog load_drive(const DriveSources& sources, const Progress& progress);

}  // namespace arpent::tools
