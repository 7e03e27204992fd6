// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/drive_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "common/error.h"

namespace arpent::tools {
namespace {

/// Tags count as seen between two observations that are no further apart.
constexpr double kTagGapS = 1.5;
constexpr double kTagShare = 0.5;
/// AgileX counts millimetres.
constexpr double kAgilexTicksPerM = 1000;

Eigen::Matrix3d planar_part(const Matrix6d& covariance) {
  const std::array<int, 3> kept{0, 1, 5};
  return covariance(kept, kept) + 1e-12 * Eigen::Matrix3d::Identity();
}

/// Seconds since the wheels began.
double seconds(const MotionLog& log, Time stamp) {
  return to_seconds(stamp - log.wheels.front().stamp);
}

double tag_share(const MotionLog& log) {
  double seen_s = 0;
  for (std::size_t i = 1; i < log.tags.size(); ++i) {
    const double gap_s = to_seconds(log.tags[i].stamp - log.tags[i - 1].stamp);
    if (gap_s <= kTagGapS) seen_s += gap_s;
  }
  return seen_s / std::max(1e-6, to_seconds(log.wheels.back().stamp - log.wheels.front().stamp));
}

void use_tags(const std::vector<tags::BodyObservation>& tags, const MotionLog& log, calib::DriveInput& input) {
  input.motion = calib::CameraMotion::kPoses;
  for (const auto& tag : tags) {
    input.camera.push_back({seconds(log, tag.stamp), tag.T_world_body, planar_part(tag.covariance)});
  }
}

/// After a loss the odometry goes on from where it was: that step is not known.
void use_odometry(const std::vector<odometry::BodyOdometry>& odometry, const MotionLog& log, calib::DriveInput& input) {
  input.motion = calib::CameraMotion::kSteps;
  bool linked = true;
  for (const auto& o : odometry) {
    if (o.status == odometry::Status::kLost) {
      linked = false;
      continue;
    }
    input.camera.push_back({seconds(log, o.stamp), o.T_odom_body, planar_part(o.step_covariance), linked});
    linked = true;
  }
}

void read_wheels(const MotionLog& log, const RobotConfig& robot, DriveLog& drive) {
  if (log.wheels.size() < 2) {
    throw InputError(log.file.string() + ": has no WHEEL_STATE of a base that was heard: log a drive with the base on");
  }
  for (const auto& w : log.wheels) drive.input.wheels.push_back({seconds(log, w.stamp), w.left_m, w.right_m});
  drive.duration_s = drive.input.wheels.back().t_s;
  drive.geometry = robot.base.geometry;
  drive.input.track_m = robot.base.geometry.track_m;
  drive.ticks_per_m = robot.base.protocol == "wifibot" ? robot.base.wifibot.odometer_ticks_per_m : kAgilexTicksPerM;
}

void read_tags(const MotionLog& log, const DriveSources& sources, const Progress& progress, DriveLog& drive) {
  const bool cube_known = !sources.tags.empty() || log.configs.contains("replay");
  if (log.pairs > 0 && cube_known) {
    const auto rig = to_calibration(drive.rig, drive.rig.name);
    use_tags(tags_from_images(log, rig, tag_config_of(log, sources.tags), progress), log, drive.input);
    drive.camera = "tags in the pictures";
  } else {
    use_tags(log.tags, log, drive.input);
    drive.input.tilt_measured = false;  // TAG_OBSERVATION is laid on the ground
    drive.camera = "TAG_OBSERVATION";
  }
  if (drive.input.camera.size() < 2) {
    throw InputError(
        fmt::format("{}: the tag cube is not seen: drive before it, or use --by odometry", log.file.string()));
  }
}

void read_odometry(const MotionLog& log, const Progress& progress, DriveLog& drive) {
  if (log.odometry.empty() && log.pairs == 0) {
    throw InputError(log.file.string() +
                     ": has neither ODOMETRY nor STEREO_IMAGES nor enough TAG_OBSERVATION: log the camera, too");
  }
  drive.camera = log.odometry.empty() ? "odometry of the pictures" : "ODOMETRY";
  use_odometry(log.odometry.empty() ? odometry_from_images(log, to_calibration(drive.rig, drive.rig.name), progress)
                                    : log.odometry,
               log, drive.input);
}

}  // namespace

DriveLog load_drive(const DriveSources& sources, const Progress& progress) {
  const MotionLog log = read_motion_log(sources.log, progress);
  DriveLog drive;
  read_wheels(log, robot_of(log, sources.robot), drive);
  drive.rig = rig_of(log, sources.rig);
  const bool by_tags = sources.by == "tags" || (sources.by == "auto" && tag_share(log) >= kTagShare);
  by_tags ? read_tags(log, sources, progress, drive) : read_odometry(log, progress, drive);
  return drive;
}

}  // namespace arpent::tools
