// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/drive_report.h"

#include <fmt/format.h>

#include "common/atomic_file.h"
#include "common/pose2.h"
#include "tools/report/html.h"

namespace arpent::tools {
namespace {

using calib::DriveCalibration;
using calib::DriveParameter;

constexpr double kDegrees = 180 / M_PI;

/// A parameter as it is told: the value that the files shall have, and half of its interval.
struct Told {
  std::string key, name, unit;
  double value, interval;
  bool observed;
};

std::vector<Told> wheels_of(const DriveLog& drive, const DriveCalibration& found) {
  const BaseGeometry g = calibrated_geometry(drive, found);
  const auto told = [&](const char* key, const char* name, const char* unit, double value, double factor,
                        DriveParameter p) {
    return Told{key, name, unit, value, calib::kConfidence * factor * found.deviation(p), found.observed(p)};
  };
  const double left = drive.ticks_per_m / g.left_scale, right = drive.ticks_per_m / g.right_scale;
  return {told("left_scale", "left scale", "", g.left_scale, drive.geometry.left_scale, calib::kLeftScale),
          told("right_scale", "right scale", "", g.right_scale, drive.geometry.right_scale, calib::kRightScale),
          told("left_ticks_per_m", "left ticks", "1/m", left, left / found.left_scale, calib::kLeftScale),
          told("right_ticks_per_m", "right ticks", "1/m", right, right / found.right_scale, calib::kRightScale),
          told("track_m", "track", "m", g.track_m, 1, calib::kTrack),
          told("time_offset_s", "wheels' clock less camera's", "s",
               found.observed(calib::kTimeOffset) ? found.time_offset_s : 0, 1, calib::kTimeOffset)};
}

std::vector<Told> body_of(const DriveLog& drive, const DriveCalibration& found) {
  const RigConfig rig = calibrated_rig(drive, found);
  const Pose2 moved = to_pose2(found.T_body_filed);
  const Pose T_body_cam = to_calibration(rig, rig.name).T_body_left;
  const auto told = [&](const char* key, const char* name, const char* unit, double value, double factor,
                        DriveParameter p) {
    return Told{key, name, unit, value, calib::kConfidence * factor * found.deviation(p), found.observed(p)};
  };
  const double yaw_deg = found.observed(calib::kMountYaw) ? kDegrees * moved.yaw_rad : 0;
  std::vector<Told> list{
      told("x_m", "camera ahead of the axle", "m", T_body_cam.translation().x(), 1, calib::kMountX),
      told("y_m", "camera to the left", "m", T_body_cam.translation().y(), 1, calib::kMountY),
      told("turned_yaw_deg", "turned against the file, yaw", "deg", yaw_deg, kDegrees, calib::kMountYaw)};
  const Eigen::Vector3d tilt = so3_log(Eigen::AngleAxisd(-moved.yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix() *
                                       found.T_body_filed.linear());
  const double tilt_deg = calib::kConfidence * kDegrees * found.tilt_deviation_rad;
  list.push_back(
      {"turned_roll_deg", "turned against the file, roll", "deg", kDegrees * tilt.x(), tilt_deg, found.tilt_observed});
  list.push_back({"turned_pitch_deg", "turned against the file, pitch", "deg", kDegrees * tilt.y(), tilt_deg,
                  found.tilt_observed});
  return list;
}

std::vector<Told> list_of(DriveSubject subject, const DriveLog& drive, const DriveCalibration& found) {
  return subject == DriveSubject::kWheels ? wheels_of(drive, found) : body_of(drive, found);
}

std::string interval_of(const Told& told) {
  return told.observed ? fmt::format("+- {:.2g}", told.interval) : "not observed";
}

std::string drive_of(const DriveLog& drive, const DriveCalibration& found) {
  return fmt::format("{:.1f} m driven, {:.0f} rad turned, {:.0f} s; {} steps; camera's motion by {}", found.driven_m,
                     found.turned_rad, drive.duration_s, found.steps, drive.camera);
}

}  // namespace

BaseGeometry calibrated_geometry(const DriveLog& drive, const DriveCalibration& found) {
  BaseGeometry g = drive.geometry;
  if (found.observed(calib::kLeftScale)) g.left_scale *= found.left_scale;
  if (found.observed(calib::kRightScale)) g.right_scale *= found.right_scale;
  if (found.observed(calib::kTrack)) g.track_m = found.track_m;
  return g;
}

RigConfig calibrated_rig(const DriveLog& drive, const DriveCalibration& found) {
  Pose T = found.T_body_filed;
  if (!found.observed(calib::kMountX)) T.translation().x() = 0;
  if (!found.observed(calib::kMountY)) T.translation().y() = 0;
  if (!found.observed(calib::kMountYaw)) {
    T.linear() = Eigen::AngleAxisd(-to_pose2(T).yaw_rad, Eigen::Vector3d::UnitZ()) * T.linear();
  }
  StereoCalibration stereo = to_calibration(drive.rig, drive.rig.name);
  stereo.T_body_left = T * stereo.T_body_left;
  RigConfig rig = drive.rig;
  rig.T_body_cam = to_rig(stereo, rig.name).T_body_cam;
  return rig;
}

std::string to_wheels_yaml(const DriveLog& drive, const DriveCalibration& found) {
  std::string yaml = "# of the robot file (config/robots): 95 % intervals\nbase:\n";
  for (const Told& told : wheels_of(drive, found)) {
    const bool in_file = told.key == "left_scale" || told.key == "right_scale" || told.key == "track_m";
    if (in_file) yaml += fmt::format("  {}: {:.6f}  # {}\n", told.key, told.value, interval_of(told));
  }
  return yaml;
}

std::string summarize(DriveSubject subject, const DriveLog& drive, const DriveCalibration& found) {
  std::string text = drive_of(drive, found) + "\n";
  for (const Told& told : list_of(subject, drive, found)) {
    text += fmt::format("{}: {:.5g} {} {}\n", told.name, told.value, told.unit, interval_of(told));
  }
  text += "Intervals hold 95 %. What this drive does not show:\n";
  for (const std::string& sentence : unobserved(found)) text += "  - " + sentence + "\n";
  return text;
}

nlohmann::json to_json(DriveSubject subject, const DriveLog& drive, const DriveCalibration& found) {
  nlohmann::json out{
      {"driven_m", found.driven_m}, {"turned_rad", found.turned_rad},     {"steps", found.steps},
      {"camera", drive.camera},     {"reduced_chi2", found.reduced_chi2}, {"unobserved", unobserved(found)}};
  for (const Told& told : list_of(subject, drive, found)) {
    out[told.key] = {{"value", told.value}, {"interval95", told.interval}, {"observed", told.observed}};
  }
  return out;
}

void write_drive_files(DriveSubject subject, const DriveLog& drive, const DriveCalibration& found,
                       const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const bool wheels = subject == DriveSubject::kWheels;
  if (wheels) {
    atomic_write(folder / "wheels.yaml", to_wheels_yaml(drive, found));
  } else {
    atomic_write(folder / "rig.yaml", config::to_yaml(calibrated_rig(drive, found)));
  }
  report::Page page(wheels ? "Wheels" : "Camera on the body", drive_of(drive, found));
  std::vector<std::vector<std::string>> rows;
  for (const Told& told : list_of(subject, drive, found)) {
    rows.push_back({told.name, fmt::format("{:.6g} {}", told.value, told.unit), interval_of(told)});
  }
  page.table({"parameter", "value", "95 %"}, rows);
  page.section("Not observed", "What this motion does not show keeps the value that it had.");
  page.list(unobserved(found));
  page.section("Way", "The body as the camera saw it go [m].");
  report::Curve way{"", "#2471a3", {}};
  for (const auto& pose : drive.input.camera) {
    way.points.emplace_back(pose.T_ref_body.translation().x(), pose.T_ref_body.translation().y());
  }
  page.plot({way}, "x [m]", "y [m]", true);
  page.write(folder);
}

}  // namespace arpent::tools
