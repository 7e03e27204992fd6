// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// sim_process on the in-memory bus, driven through real CAN frames by base_driver_process: what it publishes when, that
// pictures are of the moment that their stamp says, and that it stands where it touches something.
#include "sim/process/sim_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpent/frame_alignment_t.hpp>
#include <arpent/imu_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/pose_t.hpp>
#include <filesystem>
#include <map>

#include "common/atomic_file.h"
#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/error.h"
#include "drivers/base/process/base_driver_process.h"
#include "drivers/base/wire.h"
#include "perception/stereo/wire.h"
#include "sim/camera/renderer.h"
#include "sim/world/world.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

const fs::path kWorld = ARPENT_SOURCE_DIR "/config/worlds/test_arena.yaml";
constexpr Time kStart{100s};

/// A robot with a camera of a quarter of the usual size, so that pictures are quick.
class SimProcessTest : public testing::Test {
 protected:
  SimProcessTest() {
    fs::create_directories(folder_);
    RigConfig rig = config::load<RigConfig>(ARPENT_SOURCE_DIR "/config/rigs/wifibot_stereo.yaml");
    for (RigCamera* camera : {&rig.left, &rig.right}) *camera = {160, 128, 94.25, 94.25, 79.5, 63.5, "none", {}};
    atomic_write(folder_ / "rig.yaml", config::to_yaml(rig));
    atomic_write(robot_, std::string("rig: rig.yaml\nbase: {track_m: 0.39}\n"));
  }
  ~SimProcessTest() override { fs::remove_all(folder_); }

  SimConfig config(const std::string& sensing) const {
    SimConfig config;
    config.world = kWorld;
    config.robot = robot_;
    config.sensing = sensing;
    return config;
  }
  void start(const SimConfig& config) {
    const auto [bus, clock] = executor_.add_process(SimProcess::kName);
    health_ = &bus.health();
    sim_ = std::make_unique<SimProcess>(config, bus, clock);
    BaseDriverConfig base;
    base.robot = robot_;
    base.port = "bus";
    const auto endpoint = executor_.add_process(BaseDriverProcess::kName);
    base_ = std::make_unique<BaseDriverProcess>(base, endpoint.bus, endpoint.clock);
    executor_.set_tap([this](Time time, const std::string& channel, BytesView bytes) {
      seen_[channel].emplace_back(time, Bytes(bytes.begin(), bytes.end()));
    });
  }
  void arm() {
    executor_.run_until(kStart + 500ms);
    base::BaseRequest request{executor_.now(), base::Action::kArm, "test"};
    executor_.inject(executor_.now(), channels::kBaseRequest, encode(base::to_wire(request)));
    executor_.run_until(executor_.now() + 100ms);
  }
  void drive(const Twist2& twist, Duration duration) {
    const Time end = executor_.now() + duration;
    while (executor_.now() < end) {
      executor_.inject(executor_.now(), channels::kWheelCommand, encode(base::to_wire({executor_.now(), twist})));
      executor_.run_until(executor_.now() + 40ms);
    }
  }
  template <class Message>
  std::vector<std::pair<Time, Message>> received(const char* channel) const {
    std::vector<std::pair<Time, Message>> messages;
    const auto found = seen_.find(channel);
    if (found == seen_.end()) return messages;
    for (const auto& [time, bytes] : found->second) {
      messages.emplace_back(time, Message{});
      std::string fault;
      EXPECT_TRUE(decode_guarded(bytes, messages.back().second, fault)) << fault;
    }
    return messages;
  }
  Pose truth_at(std::int64_t utime) const {
    for (const auto& [time, m] : received<pose_t>(channels::kTruthPose)) {
      if (m.utime != utime) continue;
      const double* q = m.orientation_wxyz;
      return *make_pose(Eigen::Map<const Eigen::Vector3d>(m.position_m), {q[0], q[1], q[2], q[3]});
    }
    ADD_FAILURE() << "no truth at " << utime;
    return Pose::Identity();
  }
  std::string fault_of(const SimConfig& config) {
    try {
      const auto [bus, clock] = executor_.add_process(SimProcess::kName);
      const SimProcess process(config, bus, clock);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_ = fs::path(testing::TempDir()) /
                     (std::string("sim_process_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::path robot_ = folder_ / "robot.yaml";
  LockstepExecutor executor_{kStart};
  std::unique_ptr<SimProcess> sim_;
  std::unique_ptr<BaseDriverProcess> base_;
  Health* health_ = nullptr;
  std::map<std::string, std::vector<std::pair<Time, Bytes>>> seen_;
};

TEST_F(SimProcessTest, InertiaAndTruthCome50TimesASecondAndPairsFiveTimes) {
  start(config("images"));
  executor_.run_until(kStart + 2s);
  const auto readings = received<imu_t>(channels::kImu);
  ASSERT_EQ(readings.size(), 100U);
  for (std::size_t i = 0; i < readings.size(); ++i) {
    EXPECT_EQ(readings[i].second.sequence, static_cast<std::int64_t>(i));
    EXPECT_EQ(readings[i].second.utime, to_utime(kStart) + 20000 * static_cast<std::int64_t>(i) + 10000)
        << "the mean over a cycle is of its middle";
  }
  EXPECT_EQ(received<pose_t>(channels::kTruthPose).size(), 100U);
  const auto pairs = received<stereo_images_t>(channels::kStereoImages);
  ASSERT_EQ(pairs.size(), 10U);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& [time, pair] = pairs[i];
    EXPECT_EQ(pair.sequence, static_cast<std::int64_t>(i));
    EXPECT_EQ(pair.utime, to_utime(kStart) + 20000 + 200000 * static_cast<std::int64_t>(i));
    EXPECT_EQ(time - from_utime(pair.utime), 20ms) << "readout and transfer";
    EXPECT_GT(pair.exposure_us, 0);
  }
}

/// While the robot turns, a picture from the true pose at the pair's stamp (the middle of the exposure) is the pair's,
/// but for noise; one from 60 ms earlier is not.
TEST_F(SimProcessTest, APairShowsTheWorldFromTheTruePoseAtItsStamp) {
  start(config("images"));
  arm();
  drive({0, 1.0}, 1500ms);
  const sim::Renderer renderer(sim::load_world(kWorld));
  const Rig rig = load_rig(folder_ / "rig.yaml");
  const auto pair = received<stereo_images_t>(channels::kStereoImages).back().second;
  const auto images = stereo::from_wire(pair);
  ASSERT_TRUE(images) << images.fault();
  const auto difference = [&](std::int64_t utime, bool left) {
    sim::CameraShot shot;
    shot.exposure_s = 1e-6 * pair.exposure_us;
    shot.gain = std::pow(10, pair.gain_db / 20);
    const Pose T_world_left = truth_at(utime) * rig.calibration.T_body_left;
    const Pose T_world_cam = left ? T_world_left : T_world_left * rig.calibration.T_right_left.inverse();
    const sim::CameraModel camera(left ? rig.calibration.left : rig.calibration.right);
    const cv::Mat1b image = renderer.render(camera, T_world_cam, shot).image;
    return cv::norm(image, left ? images->left : images->right, cv::NORM_L1) / static_cast<double>(image.total());
  };
  for (const bool left : {true, false}) {
    const double now = difference(pair.utime, left);
    EXPECT_LT(now, 3.5) << "grey levels";
    EXPECT_GT(difference(pair.utime - 60000, left), 1.5 * now);
  }
}

TEST_F(SimProcessTest, WithDepthItStandsInForPerceptionAndItsOdometryFollowsTheTruth) {
  start(config("depth"));
  arm();
  drive({0.4, 0.3}, 2s);
  EXPECT_TRUE(received<stereo_images_t>(channels::kStereoImages).empty());
  const auto depth = received<depth_t>(channels::kDepth);
  const auto odometry = received<odometry_t>(channels::kOdometry);
  ASSERT_EQ(depth.size(), 13U);
  ASSERT_EQ(odometry.size(), depth.size());
  EXPECT_EQ(depth.back().second.utime, odometry.back().second.utime);
  EXPECT_TRUE(stereo::from_wire(depth.back().second));
  const auto alignments = received<frame_alignment_t>(channels::kFrameAlignment);
  ASSERT_EQ(alignments.size(), 1U);
  const auto& o = odometry.back().second;
  const double* q = o.orientation_wxyz;
  const Pose T_odom_body = *make_pose(Eigen::Map<const Eigen::Vector3d>(o.position_m), {q[0], q[1], q[2], q[3]});
  const auto& a = alignments.front().second;
  const double* p = a.orientation_wxyz;
  const Pose T_world_odom = *make_pose(Eigen::Map<const Eigen::Vector3d>(a.position_m), {p[0], p[1], p[2], p[3]});
  const Vector6d error = local(truth_at(o.utime), T_world_odom * T_odom_body);
  EXPECT_LT(error.head<3>().norm(), 0.05);
  EXPECT_LT(std::abs(error[5]), 0.03);
  EXPECT_GT(o.position_m[0], 0.4) << "it has driven";
}

TEST_F(SimProcessTest, AtAnObstacleItStandsAndTheContactIsCounted) {
  start(config("depth"));  // start 0 looks at the tag cube 1.05 m ahead
  arm();
  drive({0.4, 0}, 4s);
  EXPECT_GE(sim_->collisions(), 1) << "the motors may push again";
  EXPECT_EQ(health_->counter("WORLD", "collision"), sim_->collisions());
  EXPECT_THAT(health_->take_condition().message, HasSubstr("touches"));
  const auto truth = received<pose_t>(channels::kTruthPose);
  // The cube's face is at 2.05 m, the robot's bow 0.55 m ahead of its origin.
  EXPECT_NEAR(truth.back().second.position_m[0], 1.5, 0.02);
  drive({-0.4, 0}, 1s);
  EXPECT_LT(received<pose_t>(channels::kTruthPose).back().second.position_m[0], 1.4) << "backwards it is free";
}

TEST_F(SimProcessTest, WithoutCommandsTheRobotStandsStill) {
  start(config("depth"));
  arm();
  executor_.run_until(executor_.now() + 2s);
  const Pose end = truth_at(to_utime(executor_.now()));
  EXPECT_EQ(local(truth_at(to_utime(kStart) + 20000), end).norm(), 0);
}

TEST_F(SimProcessTest, WhatGoesWrongOnPurposeBeginsAndEndsWhenItIsSaidTo) {
  SimConfig faulty = config("depth");
  faulty.faults.silent_at_s = 1;
  faulty.faults.silent_s = 1;
  faulty.faults.blind_at_s = 3;
  faulty.faults.blind_s = 1;
  start(faulty);
  executor_.run_until(kStart + 5s);
  const auto seconds = [](const auto& received) { return 1e-6 * static_cast<double>(received.second.utime) - 100; };
  for (const auto& depth : received<depth_t>(channels::kDepth)) {
    const double s = seconds(depth);
    EXPECT_FALSE((s > 1.01 && s < 2.01) || (s > 3.01 && s < 4.01)) << s;
  }
  EXPECT_EQ(received<depth_t>(channels::kDepth).size(), 15U);
  const auto odometry = received<odometry_t>(channels::kOdometry);
  EXPECT_EQ(odometry.size(), 20U) << "when blind it still comes";
  for (const auto& step : odometry) {
    EXPECT_EQ(step.second.status == odometry_t::STATUS_LOST, seconds(step) > 3.01 && seconds(step) < 4.01);
  }
}

TEST_F(SimProcessTest, AnObstacleAppearsInTheImagesAndInTheWay) {
  SimConfig faulty = config("depth");
  faulty.start = 1;  // (1.0, 2.4, 0.7), towards the tag cube
  faulty.faults.obstacle_at_s = 3;
  faulty.faults.obstacle = {2.6, 1.3, -0.6};
  start(faulty);
  arm();
  drive({0, -1.0}, 1350ms);
  executor_.run_until(kStart + 2900ms);
  const auto ahead_m = [&] {
    const auto depth = stereo::from_wire(received<depth_t>(channels::kDepth).back().second);
    return depth->map.depth_m(80, 80);  // on the floor, 2 m ahead
  };
  const float floor_m = ahead_m();
  executor_.run_until(kStart + 4s);
  EXPECT_LT(ahead_m(), floor_m - 0.5F) << "its stern";
  EXPECT_EQ(sim_->collisions(), 0);
  drive({0.4, 0}, 5s);
  EXPECT_GE(sim_->collisions(), 1);
}

TEST_F(SimProcessTest, WhatCannotBeSimulatedIsOneClearError) {
  SimConfig bad = config("depth");
  bad.start = 7;
  EXPECT_THAT(fault_of(bad), HasSubstr("there is no start 7"));
  bad = config("depth");
  bad.world = "/no/such/world.yaml";
  EXPECT_THAT(fault_of(bad), HasSubstr("/no/such/world.yaml"));
  bad = config("depth");
  bad.robot = "/no/such/robot.yaml";
  EXPECT_THAT(fault_of(bad), HasSubstr("/no/such/robot.yaml"));
  bad = config("depth");
  bad.can = "nonsense:x";
  EXPECT_THAT(fault_of(bad), HasSubstr("nonsense:x"));
  atomic_write(robot_, std::string("rig: rig.yaml\nbase: {track_m: -0.39}\n"));
  EXPECT_THAT(fault_of(config("depth")), HasSubstr("track_m = -0.39"));
}

}  // namespace
}  // namespace arpent
