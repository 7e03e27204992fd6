// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calib/drive.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "common/pose2.h"
#include "tests/calib/simulated_drive.h"
#include "tests/perception/tags/cube_pictures.h"
#include "tests/tools/calibrate/log_messages.h"
#include "tests/tools/calibrate/verb.h"
#include "tools/calibrate/drive_report.h"
#include "tools/mission/run.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using calib::CameraMotion;
using testing::HasSubstr;

const fs::path kConfig = ARPENT_SOURCE_DIR "/config";

Matrix6d on_the_ground(const Eigen::Matrix3d& planar) {
  Matrix6d covariance = 1e-6 * Matrix6d::Identity();
  const std::array<int, 3> kept{0, 1, 5};
  covariance(kept, kept) = planar;
  return covariance;
}

/// A simulated drive as the messages that a robot's log has.
void write_drive(const fs::path& file, const calib::DriveInput& drive, bool wheels = true, bool camera = true) {
  LogWriter log(file);
  for (const auto& w : drive.wheels) {
    base::WheelState state;
    state.status.stamp = at(w.t_s);
    state.status.left_m = w.left_m;
    state.status.right_m = w.right_m;
    state.status.heard = true;
    if (wheels) write(log, w.t_s, channels::kWheelState, base::to_wire(state));
  }
  std::int64_t sequence = 0;
  for (const auto& c : drive.camera) {
    const Time stamp = at(c.t_s);
    if (!camera) continue;
    if (drive.motion == CameraMotion::kSteps) {
      odometry::BodyOdometry o;
      o.stamp = stamp;
      o.sequence = sequence++;
      o.T_odom_body = c.T_ref_body;
      o.step_covariance = o.covariance = on_the_ground(c.covariance);
      o.status = odometry::Status::kOk;
      write(log, c.t_s, channels::kOdometry, odometry::to_wire(o));
    } else {
      tags::BodyObservation o;
      o.stamp = stamp;
      o.sequence = sequence++;
      o.accepted = true;
      o.T_world_body = c.T_ref_body;
      o.covariance = on_the_ground(c.covariance);
      write(log, c.t_s, channels::kTagObservation, tags::to_wire(o));
    }
  }
  log.close();
}

class DriveVerb : public VerbTest {
 protected:
  DriveVerb() : VerbTest("calibrate_drive_test") {}

  int calibrate(const std::string& what, const std::string& log, const std::string& more = "") {
    return run(
        fmt::format("{0} --log {1}/{2} --robot {3}/robots/wifibot.yaml --rig {3}/rigs/wifibot_stereo.yaml --out "
                    "{1}/{0} --json {1}/{0}.json {4}",
                    what, folder_.string(), log, kConfig.string(), more));
  }
  nlohmann::json json(const std::string& what) const {
    return nlohmann::json::parse(std::ifstream(folder_ / (what + ".json")));
  }
};

void expect_within(const nlohmann::json& told, double truth, double intervals) {
  EXPECT_TRUE(told["observed"]);
  EXPECT_NEAR(told["value"], truth, intervals * told["interval95"].get<double>());
}

TEST_F(DriveVerb, WheelsByOdometryGivesABlockThatTheRobotFileTakes) {
  const calib::DriveTruth truth;
  write_drive(folder_ / "drive.lcm", calib::simulate_drive(truth, CameraMotion::kSteps, 1));
  ASSERT_EQ(calibrate("wheels", "drive.lcm"), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("camera's motion by ODOMETRY"));
  EXPECT_THAT(output_, HasSubstr("height of the camera"));
  const auto found = json("wheels");
  expect_within(found["left_scale"], truth.left_scale, 2);
  expect_within(found["right_scale"], truth.right_scale, 2);
  expect_within(found["track_m"], truth.track_m, 2);
  expect_within(found["time_offset_s"], truth.time_offset_s, 2);
  // A true metre is 1 / scale of what the odometer says, in millimetres.
  EXPECT_NEAR(found["left_ticks_per_m"]["value"], 1000 / truth.left_scale, 12);
  std::stringstream block;
  block << std::ifstream(folder_ / "wheels/wheels.yaml").rdbuf();
  const auto robot = config::load_text<RobotConfig>("robot", "rig: x.yaml\n" + block.str());
  EXPECT_NEAR(robot.base.geometry.track_m, truth.track_m, 0.01);
  EXPECT_NEAR(robot.base.geometry.left_scale, truth.left_scale, 0.02);
  EXPECT_GT(fs::file_size(folder_ / "wheels/report.html"), 3000U);
}

TEST_F(DriveVerb, BodyByTagsGivesARigThatTheStackReads) {
  const calib::DriveTruth truth;
  write_drive(folder_ / "drive.lcm", calib::simulate_drive(truth, CameraMotion::kPoses, 1));
  ASSERT_EQ(calibrate("body", "drive.lcm"), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("camera's motion by TAG_OBSERVATION"));
  EXPECT_THAT(output_, HasSubstr("roll and pitch of the camera are not in the motion"));
  const Pose T_before = load_rig(kConfig / "rigs/wifibot_stereo.yaml").calibration.T_body_left;
  const Pose T_after = load_rig(folder_ / "body/rig.yaml").calibration.T_body_left;
  const Pose2 moved = to_pose2(T_after * T_before.inverse());
  EXPECT_NEAR(moved.x_m, truth.mount_x_m, 0.005);
  EXPECT_NEAR(moved.y_m, truth.mount_y_m, 0.005);
  EXPECT_NEAR(moved.yaw_rad, truth.mount_yaw_rad, 0.002);
  EXPECT_EQ(T_after.translation().z(), T_before.translation().z()) << "a drive does not show the height";
  expect_within(json("body")["turned_yaw_deg"], truth.mount_yaw_rad * 180 / M_PI, 2);
  EXPECT_FALSE(json("body")["turned_pitch_deg"]["observed"]) << "TAG_OBSERVATION is laid on the ground";
}

/// Pictures of the tag cube while the robot rocks before it, read with a rig file whose camera sits 3 cm and 2 degrees
/// from where it is, and looks 1 degree lower.
TEST_F(DriveVerb, BodyByTagsInThePicturesFindsTheCamerasPitchToo) {
  const Rig truth = load_rig(kConfig / "rigs/wifibot_stereo.yaml");
  StereoCalibration filed = truth.calibration;
  const Pose T_body_filed = Pose2{0.03, -0.02, 0.035}.to_pose() * Eigen::AngleAxisd(0.0175, Eigen::Vector3d::UnitY());
  filed.T_body_left = T_body_filed.inverse() * truth.calibration.T_body_left;
  RigConfig rig = truth.config;
  rig.T_body_cam = to_rig(filed, "filed").T_body_cam;
  std::ofstream(folder_ / "filed.yaml") << config::to_yaml(rig);
  std::ofstream(folder_ / "tags.yaml") << "rig: filed.yaml\n";
  LogWriter log(folder_ / "rocking.lcm");
  Pose2 pose = to_pose2(tags::pose_facing({}, 1.9, 2.2, 0));
  double left_m = 0, right_m = 0;
  std::int64_t pairs = 0;
  for (int i = 0; i <= 2800; ++i) {
    const double t_s = 0.005 * i;
    if (i % 4 == 0) {
      base::WheelState state;
      state.status.stamp = at(t_s);
      state.status.left_m = left_m;
      state.status.right_m = right_m;
      state.status.heard = true;
      write(log, t_s, channels::kWheelState, base::to_wire(state));
    }
    if (i % 40 == 20) {
      const auto picture = tags::render_cube({}, pose.to_pose(), static_cast<std::uint64_t>(pairs));
      write(log, t_s, channels::kStereoImages, stereo::to_wire({at(t_s), pairs++, picture.left, picture.right}, true));
    }
    const double v = 0.3 * std::cos(2 * M_PI * t_s / 6), w = 0.8 * std::cos(2 * M_PI * t_s / 3);
    left_m += (v - 0.5 * 0.40 * w) * 0.005;
    right_m += (v + 0.5 * 0.40 * w) * 0.005;
    pose = {pose.x_m + v * 0.005 * std::cos(pose.yaw_rad), pose.y_m + v * 0.005 * std::sin(pose.yaw_rad),
            pose.yaw_rad + w * 0.005};
  }
  log.close();
  const std::string files = fmt::format("--robot {0}/robots/wifibot.yaml --rig {1}/filed.yaml --tags {1}/tags.yaml",
                                        kConfig.string(), folder_.string());
  ASSERT_EQ(run(fmt::format("body --by tags --log {0}/rocking.lcm --out {0}/body {1}", folder_.string(), files)), 0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("tags in the pictures"));
  const Pose T_found = load_rig(folder_ / "body/rig.yaml").calibration.T_body_left;
  const Eigen::Vector3d off_m = T_found.translation() - truth.calibration.T_body_left.translation();
  EXPECT_LT(off_m.head<2>().norm(), 0.01);
  EXPECT_LT(so3_log(truth.calibration.T_body_left.linear().transpose() * T_found.linear()).norm(), 0.005);
}

TEST_F(DriveVerb, WhatACircleDoesNotShowKeepsItsValue) {
  calib::DriveInput circle = calib::simulate_drive({}, CameraMotion::kSteps, 2, true);
  circle.camera.erase(circle.camera.begin(), circle.camera.begin() + 25);
  write_drive(folder_ / "circle.lcm", circle);
  ASSERT_EQ(calibrate("wheels", "circle.lcm"), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("do not drive in one circle"));
  EXPECT_FALSE(json("wheels")["track_m"]["observed"]);
  EXPECT_EQ(json("wheels")["track_m"]["value"], 0.39) << "the robot file's";
  EXPECT_EQ(json("wheels")["left_scale"]["value"], 1);
}

TEST_F(DriveVerb, SaysInASentenceWhatALogLacks) {
  const calib::DriveInput drive = calib::simulate_drive({}, CameraMotion::kSteps, 3);
  write_drive(folder_ / "no_wheels.lcm", drive, false);
  EXPECT_EQ(calibrate("wheels", "no_wheels.lcm"), 2);
  EXPECT_THAT(output_, HasSubstr("has no WHEEL_STATE"));
  write_drive(folder_ / "no_camera.lcm", drive, true, false);
  EXPECT_EQ(calibrate("wheels", "no_camera.lcm"), 2);
  EXPECT_THAT(output_, HasSubstr("has neither ODOMETRY nor STEREO_IMAGES"));
  calib::DriveInput standing = drive;
  for (auto& w : standing.wheels) w.left_m = w.right_m = 0;
  for (auto& c : standing.camera) c.T_ref_body = Pose::Identity();
  write_drive(folder_ / "standing.lcm", standing);
  EXPECT_EQ(calibrate("body", "standing.lcm"), 2);
  EXPECT_THAT(output_, HasSubstr("no motion to speak of"));
  calib::DriveInput apart = drive;
  for (auto& c : apart.camera) c.t_s += 5000;
  write_drive(folder_ / "apart.lcm", apart);
  EXPECT_EQ(calibrate("wheels", "apart.lcm"), 2);
  EXPECT_THAT(output_, HasSubstr("clocks apart"));
  EXPECT_EQ(run(fmt::format("wheels --log {0}/apart.lcm --out {0}/x", folder_.string())), 2);
  EXPECT_THAT(output_, HasSubstr("brings no robot along (CONFIG): name its file with --robot"));
  EXPECT_EQ(run(fmt::format("body --log {0}/none.lcm --out {0}/x", folder_.string())), 2);
  EXPECT_EQ(run("wheels --help"), 0);
  EXPECT_THAT(output_, HasSubstr("WHEEL_STATE"));
}

/// The square mission's own log, one lap: the simulator's wheels slip by 1 % and stand 1 % further apart than the robot
/// file says; its cameras sit where the rig file says, and all clocks are one.
TEST_F(DriveVerb, FindsTheSimulatorsTrueWheelsAndMountingInTheLogOfASquare) {
  MissionOverrides overrides;
  overrides.sensing = "depth";
  overrides.settings = {"mission.loop.laps=1"};
  const MissionSpec spec = load_mission(kConfig / "missions/square.yaml", overrides);
  MissionOptions options;
  options.out = folder_ / "square";
  options.progress = false;
  ASSERT_TRUE(run_mission(spec, options).done());
  const std::string log = (options.out / "mission.lcmlog").string();
  for (const char* what : {"wheels", "body"}) {
    ASSERT_EQ(run(fmt::format("{0} --log {1} --out {2}/{0} --json {2}/{0}.json", what, log, folder_.string())), 0)
        << output_;
  }
  const auto wheels = json("wheels"), body = json("body");
  expect_within(wheels["left_scale"], 0.99, 1);
  expect_within(wheels["right_scale"], 0.99, 1);
  expect_within(wheels["track_m"], 1.01 * 0.39, 1);
  EXPECT_NEAR(wheels["time_offset_s"]["value"], 0, 0.006);
  EXPECT_NEAR(body["x_m"]["value"], 0.20, 0.005);
  EXPECT_NEAR(body["y_m"]["value"], 0.13, 0.005);
  EXPECT_NEAR(body["turned_yaw_deg"]["value"], 0, 0.2);
}

}  // namespace
}  // namespace arpent::tools
