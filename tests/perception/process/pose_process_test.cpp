// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// pose_process on the in-memory bus: one POSE per wheel state without jumps, one PAIR_POSE per odometry, and what it
// does with garbage.
#include "perception/process/pose_process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "perception/fusion/wire.h"
#include "tests/perception/fusion/drive.h"

namespace arpent {
namespace {

using fusion::Drive;
using fusion::FusedPose;
using fusion::Status;
using std::chrono::milliseconds;

void write(const Pose& pose, double (&position_m)[3], double (&wxyz)[4]) {
  const Eigen::Quaterniond q = canonical_quaternion(pose.linear());
  for (int i = 0; i < 3; ++i) position_m[i] = pose.translation()[i];
  const double values[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(values, values + 4, wxyz);
}

wheel_state_t to_message(const fusion::WheelReading& r) {
  wheel_state_t m{};
  m.utime = to_utime(r.stamp);
  m.left_m = r.left_m;
  m.right_m = r.right_m;
  m.commanded_speed_mps = r.commanded.speed_mps;
  m.commanded_turn_rate_radps = r.commanded.turn_rate_radps;
  m.heard = r.usable ? 1 : 0;
  return m;
}

imu_t to_message(const fusion::GyroReading& r) {
  imu_t m{};
  m.utime = to_utime(r.stamp);
  m.angular_velocity_radps[2] = r.yaw_rate_radps;
  return m;
}

odometry_t to_message(const fusion::OdometryReading& r) {
  odometry_t m{};
  m.utime = to_utime(r.stamp);
  m.sequence = r.sequence;
  m.frame = "odom";
  m.child_frame = "body";
  write(r.T_odom_body, m.position_m, m.orientation_wxyz);
  for (int i = 0; i < 6; ++i) m.step_covariance[i][i] = r.step_covariance(i, i);
  m.status = r.usable ? odometry_t::STATUS_OK : odometry_t::STATUS_LOST;
  m.reason = r.reason;
  return m;
}

frame_alignment_t make_alignment(Time stamp, const Pose& T_world_odom) {
  frame_alignment_t m{};
  m.utime = to_utime(stamp);
  m.frame = "world";
  m.child_frame = "odom";
  write(T_world_odom, m.position_m, m.orientation_wxyz);
  for (int i = 0; i < 6; ++i) m.covariance[i][i] = 1e-4;
  return m;
}

class PoseProcessTest : public testing::Test {
 protected:
  PoseProcessTest() { start({}); }

  void start(const PoseConfig& config) {
    executor_ = std::make_unique<LockstepExecutor>(from_utime(99000000));
    const auto [bus, clock] = executor_->add_process("pose_process");
    process_ = std::make_unique<PoseProcess>(config, bus, clock);
    health_ = &bus.health();
    bytes_.clear();
    seen_.clear();
    executor_->set_tap([this](Time, const std::string& channel, BytesView bytes) {
      if (channel != channels::kPose && channel != channels::kPairPose) return;
      bytes_[channel].insert(bytes_[channel].end(), bytes.begin(), bytes.end());
      body_pose_t message;
      std::string fault;
      ASSERT_TRUE(decode_guarded(bytes, message, fault)) << fault;
      const auto pose = fusion::from_wire(message);
      ASSERT_TRUE(pose) << pose.fault();
      seen_[channel].emplace_back(message.sequence, *pose);
    });
  }

  template <class Message>
  void inject(Time time, const char* channel, const Message& message) {
    executor_->inject(time, channel, encode(message));
  }
  /// `gyro_delay`: how much later than the wheels the gyro comes.
  void play(const Drive& drive, Duration gyro_delay = Duration(0), Duration odometry_delay = milliseconds(130)) {
    for (const auto& r : drive.gyro) inject(r.stamp + gyro_delay, channels::kImu, to_message(r));
    for (const auto& r : drive.wheels) inject(r.stamp, channels::kWheelState, to_message(r));
    for (const auto& r : drive.odometry) inject(r.stamp + odometry_delay, channels::kOdometry, to_message(r));
  }
  /// Those that count by the end: the wheels are 120 ms beyond them.
  static std::size_t answered(const Drive& drive) {
    const Time last = drive.wheels.back().stamp - milliseconds(120);
    return static_cast<std::size_t>(std::count_if(drive.odometry.begin(), drive.odometry.end(),
                                                  [&](const auto& reading) { return reading.stamp <= last; }));
  }
  [[nodiscard]] const std::vector<std::pair<std::int64_t, FusedPose>>& poses() { return seen_[channels::kPose]; }
  [[nodiscard]] const std::vector<std::pair<std::int64_t, FusedPose>>& pair_poses() {
    return seen_[channels::kPairPose];
  }

  std::unique_ptr<LockstepExecutor> executor_;
  std::unique_ptr<PoseProcess> process_;
  Health* health_ = nullptr;
  std::map<std::string, Bytes> bytes_;
  std::map<std::string, std::vector<std::pair<std::int64_t, FusedPose>>> seen_;
};

TEST_F(PoseProcessTest, EachWheelStateGivesAPoseAndEachOdometryAPairPose) {
  const Drive drive = fusion::make_drive({.duration_s = 20});
  play(drive);
  executor_->run_until_idle();
  ASSERT_EQ(poses().size(), drive.wheels.size());
  ASSERT_EQ(pair_poses().size(), answered(drive));
  for (std::size_t i = 0; i < drive.wheels.size(); ++i) {
    ASSERT_EQ(poses()[i].first, static_cast<std::int64_t>(i));
    ASSERT_EQ(poses()[i].second.stamp, drive.wheels[i].stamp);
  }
  for (std::size_t i = 0; i < pair_poses().size(); ++i) {
    ASSERT_EQ(pair_poses()[i].first, drive.odometry[i].sequence);
    ASSERT_EQ(pair_poses()[i].second.stamp, drive.odometry[i].stamp);
    ASSERT_EQ(pair_poses()[i].second.status, Status::kOk);
    ASSERT_LT(fusion::error(pair_poses()[i].second, drive).norm(), 0.1);
  }
  EXPECT_LT(fusion::error(poses().back().second, drive).norm(), 0.1);
  EXPECT_EQ(poses().back().second.frame, fusion::Frame::kOdom);
}

TEST_F(PoseProcessTest, PoseDoesNotJumpAcrossCorrectionsAnOutageAndTags) {
  fusion::DriveParams p;
  p.duration_s = 40;
  p.distance_scale = 0.04;  // so that the outage ends with a correction of 10 cm
  p.odometry_fault = [](double t_s, fusion::OdometryReading& r) {
    if (t_s > 4 && t_s < 9) r.usable = r.anchored = false;
  };
  const Drive drive = fusion::make_drive(p);
  play(drive);
  const Pose T_world_odom = Pose2{3, 4, 2}.to_pose();
  inject(drive.wheels[100].stamp, channels::kFrameAlignment, make_alignment(drive.odometry[8].stamp, T_world_odom));
  for (std::size_t i = 60; i < 200; i += 20) {
    // Tags that are 10 cm off, within what they say of themselves.
    tag_observation_t m{};
    m.utime = to_utime(drive.odometry[i].stamp);
    m.accepted = 1;
    m.frame = "world";
    m.child_frame = "body";
    Pose T = T_world_odom * drive.truth.at(drive.odometry[i].stamp);
    T.translation().y() += 0.1;
    write(T, m.position_m, m.orientation_wxyz);
    for (int k = 0; k < 6; ++k) m.covariance[k][k] = 0.0025;
    inject(drive.odometry[i].stamp + milliseconds(150), channels::kTagObservation, m);
  }
  executor_->run_until_idle();
  ASSERT_GT(health_->counter(channels::kTagObservation, "used"), 4);
  const fusion::BlendParams blend;
  int world = 0;
  for (std::size_t i = 1; i < poses().size(); ++i) {
    const FusedPose& a = poses()[i - 1].second;
    const FusedPose& b = poses()[i].second;
    if (a.frame != b.frame || a.status == Status::kLost) continue;
    world += b.frame == fusion::Frame::kWorld ? 1 : 0;
    // Beyond the true motion: the blend's limits, the wheels' scale, and noise of a 20 ms step (five deviations).
    const Vector6d beyond =
        local(a.T_frame_body, b.T_frame_body) - local(drive.truth.at(a.stamp), drive.truth.at(b.stamp));
    ASSERT_LT(beyond.head<3>().norm(), blend.max_mps * 0.02 + 0.04 * 0.01 + 5 * 0.01 * std::sqrt(0.01)) << i;
    ASSERT_LT(beyond.tail<3>().norm(), blend.max_radps * 0.02 + 5 * 0.002 * std::sqrt(0.02)) << i;
  }
  EXPECT_GT(world, 1800);
}

TEST_F(PoseProcessTest, AnAlignmentSetsTheWorldAtOnce) {
  const Drive drive = fusion::make_drive({.duration_s = 6});
  play(drive);
  const Pose T_world_odom = Pose2{3, 4, 2}.to_pose();
  inject(drive.wheels[100].stamp, channels::kFrameAlignment, make_alignment(drive.odometry[8].stamp, T_world_odom));
  executor_->run_until_idle();
  EXPECT_EQ(poses()[99].second.frame, fusion::Frame::kOdom);
  EXPECT_EQ(poses()[101].second.frame, fusion::Frame::kWorld);
  EXPECT_LT(local(poses()[101].second.T_frame_body, T_world_odom).norm(), 0.03);
  EXPECT_EQ(pair_poses().back().second.frame, fusion::Frame::kWorld);
}

TEST_F(PoseProcessTest, AGyroThatComesLaterThanTheWheelsChangesNoByte) {
  const Drive drive = fusion::make_drive({.duration_s = 8, .gyro_bias_radps = 0.02});
  play(drive);
  executor_->run_until_idle();
  const auto reference = bytes_;
  ASSERT_GT(reference.at(channels::kPose).size(), 100000U);
  start({});
  play(drive, milliseconds(9));
  executor_->run_until_idle();
  EXPECT_EQ(bytes_, reference);
}

TEST_F(PoseProcessTest, NoByteDependsOnHowLateTheOdometryComesWithinItsTime) {
  const Drive drive = fusion::make_drive({.duration_s = 8});
  play(drive, Duration(0), milliseconds(21));
  executor_->run_until_idle();
  const auto reference = bytes_;
  for (const int delay_ms : {47, 119}) {
    start({});
    play(drive, milliseconds(5), milliseconds(delay_ms));
    executor_->run_until_idle();
    EXPECT_EQ(bytes_, reference) << delay_ms;
    EXPECT_EQ(health_->counter(channels::kOdometry, "late"), 0);
  }
}

TEST_F(PoseProcessTest, WhatComesInAnyOrderAmongSendersGivesTheSameBytes) {
  const Drive drive = fusion::make_drive({.duration_s = 8, .gyro_bias_radps = 0.02});
  play(drive, Duration(0), milliseconds(50));
  executor_->run_until_idle();
  const auto reference = bytes_;
  std::mt19937 random(5);
  for (int trial = 0; trial < 5; ++trial) {
    start({});
    const auto some = [&](int most_ms) { return milliseconds(random() % static_cast<unsigned>(most_ms)); };
    for (const auto& r : drive.gyro) inject(r.stamp + some(10), channels::kImu, to_message(r));
    for (const auto& r : drive.wheels) inject(r.stamp + some(20), channels::kWheelState, to_message(r));
    for (const auto& r : drive.odometry) inject(r.stamp + some(120), channels::kOdometry, to_message(r));
    executor_->run_until_idle();
    EXPECT_EQ(bytes_, reference) << trial;
  }
}

TEST_F(PoseProcessTest, OdometryThatComesTooLateCountsAtOnceAndGivesTheSamePairPoses) {
  const Drive drive = fusion::make_drive({.duration_s = 8});
  play(drive, Duration(0), milliseconds(61));
  executor_->run_until_idle();
  const Bytes reference = bytes_[channels::kPairPose];
  for (const int delay_ms : {133, 700}) {
    start({});
    play(drive, Duration(0), milliseconds(delay_ms));
    executor_->run_until_idle();
    EXPECT_EQ(bytes_[channels::kPairPose], reference) << delay_ms;
    EXPECT_GT(health_->counter(channels::kOdometry, "late"), 20);
  }
}

TEST_F(PoseProcessTest, WithoutWheelsEachOdometryIsAnsweredAtOnce) {
  Drive drive = fusion::make_drive({.duration_s = 4});
  drive.wheels.clear();
  drive.gyro.clear();
  play(drive);
  executor_->run_until_idle();
  EXPECT_EQ(pair_poses().size(), drive.odometry.size());
}

TEST_F(PoseProcessTest, ASilentGyroHoldsNothingUp) {
  Drive drive = fusion::make_drive({.duration_s = 8});
  drive.gyro.resize(400);
  play(drive);
  executor_->run_until_idle();
  EXPECT_EQ(poses().size(), drive.wheels.size());
  start({});
  drive.gyro.clear();
  play(drive);
  executor_->run_until_idle();
  EXPECT_EQ(poses().size(), drive.wheels.size());
}

TEST_F(PoseProcessTest, ABaseThatRepeatsItsLastReadingLeavesOdometryInCharge) {
  Drive drive = fusion::make_drive({.duration_s = 10, .profile = [](double t_s) {
                                      return t_s < 2 ? Twist2{} : Twist2{0.4, 0};
                                    }});
  const std::vector<fusion::WheelReading> wheels = std::move(drive.wheels);
  drive.wheels.clear();
  play(drive);
  for (std::size_t i = 0; i < wheels.size(); ++i) {
    inject(wheels[i].stamp, channels::kWheelState, to_message(wheels[std::min<std::size_t>(i, 250)]));
  }
  executor_->run_until_idle();
  EXPECT_GT(poses().size(), 490U);
  EXPECT_GT(health_->counter(channels::kWheelState, "repeated"), 240);
  EXPECT_EQ(pair_poses().back().second.status, Status::kOk);
  EXPECT_LT(fusion::error(poses().back().second, drive).norm(), 0.1);
}

TEST_F(PoseProcessTest, ALostPairIsAnsweredToo) {
  fusion::DriveParams p;
  p.duration_s = 6;
  p.odometry_fault = [](double t_s, fusion::OdometryReading& r) {
    if (t_s > 5) r.usable = r.anchored = false, r.reason = "dark";
  };
  const Drive drive = fusion::make_drive(p);
  play(drive);
  executor_->run_until_idle();
  ASSERT_EQ(pair_poses().size(), answered(drive));
  EXPECT_EQ(pair_poses().back().second.status, Status::kDeadReckoning);
  EXPECT_EQ(pair_poses().back().second.reason, "visual odometry: dark");
}

TEST_F(PoseProcessTest, GarbageIsCountedAndChangesNothing) {
  const Drive drive = fusion::make_drive({.duration_s = 4});
  play(drive);
  executor_->run_until_idle();
  const auto reference = bytes_;
  start({});
  play(drive);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Time t = drive.wheels[100].stamp + Duration(1);
  wheel_state_t wheels = to_message(drive.wheels[101]);
  wheels.left_m = nan;
  inject(t, channels::kWheelState, wheels);
  inject(t, channels::kWheelState, to_message(drive.wheels[50]));
  imu_t imu = to_message(drive.gyro[202]);
  imu.angular_velocity_radps[2] = nan;
  inject(t, channels::kImu, imu);
  odometry_t odometry = to_message(drive.odometry[10]);
  odometry.position_m[0] = nan;
  inject(t, channels::kOdometry, odometry);
  odometry = to_message(drive.odometry[10]);
  odometry.frame = "world";
  inject(t, channels::kOdometry, odometry);
  frame_alignment_t alignment = make_alignment(t, Pose::Identity());
  alignment.frame = "map";
  inject(t, channels::kFrameAlignment, alignment);
  executor_->inject(t, channels::kOdometry, Bytes(50, 0xFF));
  executor_->run_until_idle();
  EXPECT_EQ(bytes_, reference);
  EXPECT_EQ(health_->counter(channels::kWheelState, "invalid"), 2);
  EXPECT_EQ(health_->counter(channels::kImu, "invalid"), 1);
  EXPECT_EQ(health_->counter(channels::kOdometry, "invalid"), 2);
  EXPECT_EQ(health_->counter(channels::kOdometry, "undecodable"), 1);
  EXPECT_EQ(health_->counter(channels::kFrameAlignment, "invalid"), 1);
}

/// The driver publishes its state from its first cycle on, long before a base answers.
TEST_F(PoseProcessTest, StatesOfABaseThatHasNotBeenHeardGiveNoPose) {
  const Drive drive = fusion::make_drive({.duration_s = 4});
  play(drive);
  executor_->run_until_idle();
  const auto reference = bytes_;
  start({});
  wheel_state_t unheard = to_message(drive.wheels[0]);
  unheard.utime = 0;
  unheard.heard = 0;
  for (int i = 10; i > 0; --i) inject(drive.wheels[0].stamp - Duration(20000 * i), channels::kWheelState, unheard);
  play(drive);
  executor_->run_until_idle();
  EXPECT_EQ(bytes_, reference);
  EXPECT_EQ(health_->counter(channels::kWheelState, "silent"), 10);
  EXPECT_EQ(health_->counter(channels::kImu, "invalid"), 0);
}

TEST_F(PoseProcessTest, WithoutAnImuInTheConfigWheelsGiveTheTurn) {
  PoseConfig config;
  config.fusion.gyro.used = false;
  start(config);
  const Drive drive = fusion::make_drive({.duration_s = 10});
  play(drive);
  executor_->run_until_idle();
  EXPECT_EQ(health_->counter(channels::kImu, "received"), 0);
  EXPECT_EQ(poses().size(), drive.wheels.size());
  EXPECT_LT(fusion::error(poses().back().second, drive).norm(), 0.1);
}

}  // namespace
}  // namespace arpent
