// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/camera_imu_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calib/board_motion.h"
#include "calib/output.h"
#include "common/atomic_file.h"
#include "common/error.h"
#include "tools/report/html.h"

namespace arpent::tools {
namespace {

using calib::CameraImuCalibration;

constexpr double kDegrees = 180 / M_PI;

/// Seconds since the readings began.
double seconds(const MotionLog& log, Time stamp) {
  return to_seconds(stamp - log.imu.front().stamp);
}

void use_board(const MotionLog& log, const std::filesystem::path& target_file, const Progress& progress,
               CameraImuLog& out) {
  const calib::Target target = calib::load_target(target_file);
  const calib::BoardDetector detector(target);
  const PinholeCamera &left = out.rig.left.pinhole, &right = out.rig.right.pinhole;
  calib::BoardViews views{
      target, {{"left", left.width_px, left.height_px}, {"right", right.width_px, right.height_px}}, {}};
  std::vector<double> times_s;
  for_each_pair(log, out.rig, progress, [&](const stereo::StereoPair& pair) {
    calib::View view{"", {detector.detect(pair.left), detector.detect(pair.right)}};
    for (auto& corners : view.cameras) {
      if (corners.size() < static_cast<std::size_t>(calib::kMinCorners)) corners.clear();
    }
    if (view.cameras[0].empty() && view.cameras[1].empty()) return;
    views.views.push_back(std::move(view));
    times_s.push_back(seconds(log, pair.stamp));
  });
  if (views.views.size() < 20) {
    throw InputError(fmt::format("{}: the board is seen in {} pairs only: keep it in the picture", log.file.string(),
                                 views.views.size()));
  }
  const auto poses =
      calib::camera_poses(views, {{out.rig.left, out.rig.right}, {Pose::Identity(), out.rig.T_right_left}, {}});
  for (std::size_t i = 0; i < poses.size(); ++i) {
    out.input.camera.push_back({times_s[i], poses[i].T_board_cam, poses[i].covariance});
  }
  out.input.motion = calib::CameraMotion::kPoses;
  out.camera = "the board";
}

void use_odometry(const MotionLog& log, const Progress& progress, CameraImuLog& out) {
  if (log.odometry.empty() && log.pairs == 0) {
    throw InputError(log.file.string() + ": has neither ODOMETRY nor STEREO_IMAGES: log the camera, too");
  }
  out.camera = log.odometry.empty() ? "odometry of the pictures" : "ODOMETRY";
  const auto odometry = log.odometry.empty() ? odometry_from_images(log, out.rig, progress) : log.odometry;
  const Matrix6d to_camera = adjoint(out.rig.T_body_left.inverse());
  bool linked = true;
  for (const auto& o : odometry) {
    if (o.status == odometry::Status::kLost) {
      linked = false;
      continue;
    }
    const Matrix6d covariance = to_camera * o.step_covariance * to_camera.transpose() + 1e-14 * Matrix6d::Identity();
    out.input.camera.push_back({seconds(log, o.stamp), o.T_odom_body * out.rig.T_body_left, covariance, linked});
    linked = true;
  }
  out.input.motion = calib::CameraMotion::kSteps;
}

std::vector<std::array<std::string, 3>> rows_of(const CameraImuLog& log, const CameraImuCalibration& found) {
  const Eigen::Vector3d off_rad = so3_log(log.input.T_cam_imu.linear().transpose() * found.T_cam_imu.linear());
  const Eigen::Vector3d t = found.T_cam_imu.translation();
  std::vector<std::array<std::string, 3>> rows;
  const auto add = [&](const std::string& name, double value, const char* unit, int parameter, double factor,
                       double worth) {
    const double deviation = found.deviation(parameter);
    const bool observed = deviation <= worth;
    rows.push_back({name, observed ? fmt::format("{:.2f} {}", factor * value, unit) : "-",
                    observed ? fmt::format("+- {:.2g}", calib::kConfidence * factor * deviation) : "not observed"});
  };
  const char* axes = "xyz";
  for (int k = 0; k < 3; ++k) {
    add(fmt::format("turned against the file, about the unit's {}", axes[k]), off_rad[k], "deg", calib::kMountTurn + k,
        kDegrees, calib::kTurnWorth);
  }
  for (int k = 0; k < 3; ++k) {
    add(fmt::format("place in the camera, {}", axes[k]), t[k], "mm", calib::kMountPlace + k, 1e3, calib::kPlaceWorthM);
  }
  add("unit's clock less camera's", found.time_offset_s, "ms", calib::kImuTimeOffset, 1e3, calib::kOffsetWorthS);
  return rows;
}

std::string motion_of(const CameraImuLog& log, const CameraImuCalibration& found) {
  return fmt::format("{:.1f} s, {:.0f} rad turned, {} steps; camera's motion by {}; {:.2f} times the stated noise",
                     found.duration_s, found.turned_rad, found.steps, log.camera, std::sqrt(found.reduced_chi2));
}

Eigen::Quaterniond mount_of(const CameraImuLog& log, const CameraImuCalibration& found) {
  return canonical_quaternion(log.rig.T_body_left.linear() * found.T_cam_imu.linear());
}

}  // namespace

CameraImuLog load_camera_imu(const CameraImuSources& sources, const Progress& progress) {
  const MotionLog log = read_motion_log(sources.log, progress);
  if (log.imu.size() < 2) throw InputError(sources.log.string() + ": has no IMU readings: log the inertial unit, too");
  CameraImuLog out;
  const RigConfig rig = rig_of(log, sources.rig);
  out.rig = to_calibration(rig, rig.name);
  for (const auto& r : log.imu) {
    out.input.imu.push_back({seconds(log, r.stamp), r.angular_velocity_radps, r.acceleration_mps2});
  }
  // Readings are in body axes by imu_process' mounting.
  out.input.T_cam_imu = out.rig.T_body_left.inverse();
  sources.target.empty() ? use_odometry(log, progress, out) : use_board(log, sources.target, progress, out);
  return out;
}

std::string to_imucam_yaml(const CameraImuLog& log, const CameraImuCalibration& found) {
  std::string yaml =
      calib::to_camchain_yaml({{log.rig.left, log.rig.right}, {Pose::Identity(), log.rig.T_right_left}, {}});
  std::string added;
  if (found.rotation_observed() && found.place_observed()) {
    added += "  T_cam_imu:\n";
    for (int r = 0; r < 4; ++r) {
      const auto row = found.T_cam_imu.matrix().row(r);
      added += fmt::format("  - [{:.12f}, {:.12f}, {:.12f}, {:.12f}]\n", row[0], row[1], row[2], row[3]);
    }
  }
  if (found.time_offset_observed()) added += fmt::format("  timeshift_cam_imu: {:.9f}\n", found.time_offset_s);
  const std::size_t second = yaml.find("cam1:");
  return yaml.insert(second, added);
}

std::string to_mount_yaml(const CameraImuLog& log, const CameraImuCalibration& found) {
  const Eigen::Quaterniond q = mount_of(log, found);
  return fmt::format(
      "# imu_process: a log made with [1, 0, 0, 0] gives the mounting itself, another one what to turn it by, from the "
      "left\nmount_quaternion_wxyz: [{:.9f}, {:.9f}, {:.9f}, {:.9f}]\n",
      q.w(), q.x(), q.y(), q.z());
}

std::string summarize(const CameraImuLog& log, const CameraImuCalibration& found) {
  std::string text = motion_of(log, found) + "\n";
  for (const auto& [name, value, interval] : rows_of(log, found)) {
    text += fmt::format("{}: {} {}\n", name, value, interval);
  }
  text += "Intervals hold 95 %.\n";
  const auto sentences = unobserved(found);
  if (!sentences.empty()) text += "What this motion does not show:\n";
  for (const std::string& sentence : sentences) text += "  - " + sentence + "\n";
  return text;
}

nlohmann::json to_json(const CameraImuLog& log, const CameraImuCalibration& found) {
  const Eigen::Quaterniond q = canonical_quaternion(found.T_cam_imu.linear());
  const Eigen::Vector3d t = found.T_cam_imu.translation();
  nlohmann::json place, turn;  // null: not observed
  if (found.place_observed()) place = {t.x(), t.y(), t.z()};
  if (found.rotation_observed()) turn = {q.w(), q.x(), q.y(), q.z()};
  return {{"steps", found.steps},
          {"turned_rad", found.turned_rad},
          {"camera", log.camera},
          {"reduced_chi2", found.reduced_chi2},
          {"unobserved", unobserved(found)},
          {"T_cam_imu",
           {{"translation_m", place},
            {"quaternion_wxyz", turn},
            {"rotation_interval95_deg", calib::kConfidence * kDegrees * found.worst_deviation(calib::kMountTurn)},
            {"place_interval95_m", calib::kConfidence * found.worst_deviation(calib::kMountPlace)},
            {"rotation_observed", found.rotation_observed()},
            {"place_observed", found.place_observed()}}},
          {"time_offset_s",
           {{"value", found.time_offset_s},
            {"interval95", calib::kConfidence * found.deviation(calib::kImuTimeOffset)},
            {"observed", found.time_offset_observed()}}}};
}

void write_camera_imu_files(const CameraImuLog& log, const CameraImuCalibration& found,
                            const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  atomic_write(folder / "camchain-imucam.yaml", to_imucam_yaml(log, found));
  if (found.rotation_observed()) atomic_write(folder / "imu_mount.yaml", to_mount_yaml(log, found));
  report::Page page("Camera and inertial unit", motion_of(log, found));
  std::vector<std::vector<std::string>> rows;
  for (const auto& row : rows_of(log, found)) rows.emplace_back(row.begin(), row.end());
  page.table({"parameter", "value", "95 %"}, rows);
  page.section("Not observed", "What this motion does not show is not in the files.");
  page.list(unobserved(found));
  page.section("Turn rates", "Of the gyro, less its bias [rad/s].");
  std::vector<report::Curve> curves{{"x", "#c0392b", {}}, {"y", "#1e8449", {}}, {"z", "#2471a3", {}}};
  for (const auto& s : log.input.imu) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      curves[k].points.emplace_back(s.t_s, s.angular_velocity_radps[i] - found.gyro_bias_radps[i]);
    }
  }
  page.plot(curves, "time [s]", "turn rate [rad/s]", false);
  page.write(folder);
}

}  // namespace arpent::tools
