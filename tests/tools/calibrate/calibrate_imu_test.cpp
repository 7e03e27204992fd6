// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/log/event_log.h"
#include "drivers/imu/wire.h"
#include "perception/odometry/wire.h"
#include "perception/stereo/calibration_file.h"
#include "perception/stereo/wire.h"
#include "tests/calib/board_picture.h"
#include "tests/calib/simulated_imu.h"
#include "tests/tools/calibrate/log_messages.h"
#include "tests/tools/calibrate/verb.h"
#include "tools/calibrate/motion_log.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using calib::CameraMotion;
using testing::HasSubstr;

const fs::path kRig = ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml";

void write_readings(LogWriter& log, const calib::CameraImuInput& input) {
  std::int64_t sequence = 0;
  for (const auto& s : input.imu) {
    write(log, s.t_s, channels::kImu,
          imu::to_wire({at(s.t_s), s.angular_velocity_radps, s.acceleration_mps2}, sequence++));
  }
}

void write_odometry(LogWriter& log, const calib::CameraImuInput& input) {
  const Pose T_body_cam = load_rig(kRig).calibration.T_body_left;
  const Matrix6d to_body = adjoint(T_body_cam);
  std::int64_t sequence = 0;
  for (const auto& c : input.camera) {
    odometry::BodyOdometry o;
    o.stamp = at(c.t_s);
    o.sequence = sequence++;
    o.T_odom_body = c.T_ref_cam * T_body_cam.inverse();
    o.step_covariance = o.covariance = to_body * c.covariance * to_body.transpose();
    o.status = odometry::Status::kOk;
    write(log, c.t_s, channels::kOdometry, odometry::to_wire(o));
  }
}

class CameraImuVerb : public VerbTest {
 protected:
  CameraImuVerb() : VerbTest("calibrate_imu_test") {}
  int calibrate(const std::string& log, const std::string& more = "", const fs::path& rig = kRig) {
    return run(fmt::format("camera-imu --log {0}/{1} --rig {2} --out {0}/out --json {0}/out.json {3}", folder_.string(),
                           log, rig.string(), more));
  }
  nlohmann::json json() const { return nlohmann::json::parse(std::ifstream(folder_ / "out.json")); }
};

void expect_truth(const nlohmann::json& json, const calib::ImuTruth& truth) {
  const auto q = json["T_cam_imu"]["quaternion_wxyz"];
  const Eigen::Quaterniond found(q[0], q[1], q[2], q[3]);
  EXPECT_LT(found.angularDistance(Eigen::Quaterniond(truth.T_cam_imu.linear())) * 180 / M_PI, 0.3);
  EXPECT_NEAR(json["time_offset_s"]["value"], truth.time_offset_s, 0.001);
  EXPECT_TRUE(json["T_cam_imu"]["place_observed"]);
}

TEST_F(CameraImuVerb, ByOdometryWritesFilesThatTheStackAndKalibrRead) {
  const calib::ImuTruth truth;
  const auto input = calib::simulate_imu(truth, CameraMotion::kSteps, calib::Excitation::kAllAxes, 5);
  LogWriter log(folder_ / "shaken.lcm");
  write_readings(log, input);
  write_odometry(log, input);
  log.close();
  ASSERT_EQ(calibrate("shaken.lcm"), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("camera's motion by ODOMETRY"));
  expect_truth(json(), truth);
  const auto chain = stereo::read_calibration(folder_ / "out/camchain-imucam.yaml", 0, 0);
  EXPECT_NEAR(chain.T_right_left.translation().x(), -0.26, 1e-9);
  std::stringstream yaml, mount;
  yaml << std::ifstream(folder_ / "out/camchain-imucam.yaml").rdbuf();
  mount << std::ifstream(folder_ / "out/imu_mount.yaml").rdbuf();
  EXPECT_THAT(yaml.str(), HasSubstr("  T_cam_imu:\n  - ["));
  EXPECT_THAT(yaml.str(), HasSubstr("  timeshift_cam_imu: 0.01"));
  EXPECT_THAT(mount.str(), HasSubstr("mount_quaternion_wxyz: ["));
}

TEST_F(CameraImuVerb, OnLevelGroundKeepsThePlaceOutOfItsFiles) {
  const auto input = calib::simulate_imu({}, CameraMotion::kSteps, calib::Excitation::kLevel, 5);
  LogWriter log(folder_ / "level.lcm");
  write_readings(log, input);
  write_odometry(log, input);
  log.close();
  ASSERT_EQ(calibrate("level.lcm"), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("What this motion does not show"));
  EXPECT_THAT(output_, HasSubstr("measure it by hand"));
  EXPECT_FALSE(json()["T_cam_imu"]["place_observed"]);
  EXPECT_TRUE(json()["T_cam_imu"]["translation_m"].is_null());
  EXPECT_FALSE(json()["T_cam_imu"]["quaternion_wxyz"].is_null());
  std::stringstream yaml;
  yaml << std::ifstream(folder_ / "out/camchain-imucam.yaml").rdbuf();
  EXPECT_THAT(yaml.str(), testing::Not(HasSubstr("T_cam_imu:")));
}

TEST_F(CameraImuVerb, ByABoardInThePicturesOfTheLog) {
  const calib::ImuTruth truth;
  auto input = calib::simulate_imu(truth, CameraMotion::kPoses, calib::Excitation::kAllAxes, 6, 0);
  RigConfig small = load_rig(kRig).config;  // a quarter of the pixels, a quarter of the test's time
  for (RigCamera* camera : {&small.left, &small.right}) {
    camera->width_px /= 2, camera->height_px /= 2;
    camera->fx_px /= 2, camera->fy_px /= 2, camera->cx_px /= 2, camera->cy_px /= 2;
  }
  std::ofstream(folder_ / "small.yaml") << config::to_yaml(small);
  const StereoCalibration rig = to_calibration(small, "small");
  calib::Target target;
  target.rows = target.columns = 3;
  target.tag_m = 0.2;
  target.border_cells = 1;
  std::ofstream(folder_ / "target.yaml") << calib::to_yaml(target);
  // The board before the camera's middle way, upright.
  const Eigen::Vector2d middle_m = 0.5 * target.size_m();
  Pose T_first_board = Pose::Identity();
  T_first_board.linear() = so3_exp({M_PI, 0, 0});
  T_first_board.translation() = Eigen::Vector3d(-middle_m.x(), middle_m.y(), 1.2);
  const Pose T_ref_board = Pose(truth.T_cam_imu.inverse()) * T_first_board;
  const sim::CameraModel left(rig.left), right(rig.right);
  LogWriter log(folder_ / "board.lcm");
  write_readings(log, input);
  input.camera.resize(55);
  std::int64_t sequence = 0;
  for (const auto& c : input.camera) {
    const Pose T_left_board = c.T_ref_cam.inverse() * T_ref_board;
    const auto seed = static_cast<std::uint64_t>(2 * sequence);
    write(log, c.t_s, channels::kStereoImages,
          stereo::to_wire({at(c.t_s), sequence++, calib::draw_board(target, left, T_left_board, seed),
                           calib::draw_board(target, right, rig.T_right_left * T_left_board, seed + 1)},
                          true));
  }
  log.close();
  ASSERT_EQ(calibrate("board.lcm", fmt::format("--target {}/target.yaml", folder_.string()), folder_ / "small.yaml"), 0)
      << output_;
  EXPECT_THAT(output_, HasSubstr("camera's motion by the board"));
  expect_truth(json(), truth);
}

TEST_F(CameraImuVerb, SaysInASentenceWhatALogLacks) {
  const auto input = calib::simulate_imu({}, CameraMotion::kSteps, calib::Excitation::kAllAxes, 5);
  LogWriter no_camera(folder_ / "no_camera.lcm"), no_imu(folder_ / "no_imu.lcm");
  write_readings(no_camera, input);
  write_odometry(no_imu, input);
  no_camera.close();
  no_imu.close();
  EXPECT_EQ(calibrate("no_camera.lcm"), 2);
  EXPECT_THAT(output_, HasSubstr("has neither ODOMETRY nor STEREO_IMAGES"));
  EXPECT_EQ(calibrate("no_imu.lcm"), 2);
  EXPECT_THAT(output_, HasSubstr("has no IMU readings"));
  EXPECT_EQ(run(fmt::format("camera-imu --log {0}/no_camera.lcm --out {0}/out", folder_.string())), 2);
  EXPECT_THAT(output_, HasSubstr("name its file with --rig"));
}

}  // namespace
}  // namespace arpent::tools
