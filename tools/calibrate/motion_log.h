// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a log says about motion, and what its pictures say when they are looked at again: wheels, odometry, tags,
// inertial readings, and the rig, robot and cube that come with it or are given as files.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "common/config/rig.h"
#include "common/config/robot.h"
#include "drivers/base/wire.h"
#include "drivers/imu/wire.h"
#include "perception/odometry/wire.h"
#include "perception/process/tag_process.h"
#include "perception/stereo/wire.h"
#include "perception/tags/wire.h"
#include "tools/calibrate/files.h"

namespace arpent::tools {

/// Whether an event's channel is `name`, perhaps with a robot's name before it.
[[nodiscard]] bool is_channel(const std::string& channel, const char* name);

struct MotionLog {
  std::filesystem::path file;
  std::map<std::string, std::string> configs;  ///< CONFIG: name -> YAML
  std::vector<base::BaseStatus> wheels;        ///< heard ones, by time, each reading once
  std::vector<odometry::BodyOdometry> odometry;
  std::vector<tags::BodyObservation> tags;  ///< accepted ones
  std::vector<imu::Reading> imu;            ///< by time
  std::size_t pairs = 0;                    ///< STEREO_IMAGES
};
/// One pass. Throws InputError if the log cannot be read or a clock in it goes back.
[[nodiscard]] MotionLog read_motion_log(const std::filesystem::path& log, const Progress& progress);

/// The file if one is given, else the log's own. Throws InputError that says which option names a file.
[[nodiscard]] RigConfig rig_of(const MotionLog& log, const std::filesystem::path& file);
[[nodiscard]] RobotConfig robot_of(const MotionLog& log, const std::filesystem::path& file);
/// As tag_process has them; the file is its configuration.
[[nodiscard]] TagConfig tag_config_of(const MotionLog& log, const std::filesystem::path& file);

/// Calls `use` for every pair of the log that can be decoded and has the rig's size.
void for_each_pair(const MotionLog& log, const StereoCalibration& rig, const Progress& progress,
                   const std::function<void(const stereo::StereoPair&)>& use);
/// Odometry computed from the log's pictures.
[[nodiscard]] std::vector<odometry::BodyOdometry> odometry_from_images(const MotionLog& log,
                                                                       const StereoCalibration& rig,
                                                                       const Progress& progress);
/// The cube seen in the log's pictures: poses of the tags alone, without the ground's help, so that tilt is measured.
[[nodiscard]] std::vector<tags::BodyObservation> tags_from_images(const MotionLog& log, const StereoCalibration& rig,
                                                                  const TagConfig& config, const Progress& progress);

}  // namespace arpent::tools
