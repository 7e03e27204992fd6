// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// mission_process of kind `loop` on the in-memory bus; the test is base, pose and path tracker.
#include "planning/process/mission_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/pose2.h"
#include "perception/fusion/wire.h"
#include "planning/mission/path_progress.h"
#include "planning/wire.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;
using planning::MissionCommand;
using planning::MissionState;
using testing::HasSubstr;

class MissionProcessTest : public testing::Test {
 protected:
  MissionProcessTest() {
    config_.loop.centre_m = {4.9, 3.5};
    config_.loop.entry_m = {4.9, 2.0};
    config_.loop.laps = 1;
    config_.max_time_s = 100;
    executor_.set_tap([this](Time, const std::string& channel, BytesView bytes) { see(channel, bytes); });
  }
  void start() {
    const auto [bus, clock] = executor_.add_process(MissionProcess::kName);
    health_ = &bus.health();
    process_ = std::make_unique<MissionProcess>(config_, bus, clock);
  }

  void see(const std::string& channel, BytesView bytes) {
    std::string fault;
    if (channel == channels::kPath) {
      paths_.emplace_back();
      ASSERT_TRUE(decode_guarded(bytes, paths_.back(), fault)) << fault;
    } else if (channel == channels::kBaseRequest) {
      requests_.emplace_back();
      ASSERT_TRUE(decode_guarded(bytes, requests_.back(), fault)) << fault;
    } else if (channel == channels::kMissionState) {
      mission_state_t message;
      ASSERT_TRUE(decode_guarded(bytes, message, fault)) << fault;
      const auto report = planning::from_wire(message);
      ASSERT_TRUE(report) << report.fault();
      reports_.push_back(*report);
    }
  }
  template <class Message>
  void send(const char* channel, const Message& message) {
    executor_.inject(executor_.now(), channel, encode(message));
  }
  void command(MissionCommand command) {
    send(channels::kMissionCommand, planning::to_wire(executor_.now(), {command, "test"}));
  }
  /// What the robot says of itself, ten times a second.
  void run(double duration_s) {
    const Time end = executor_.now() + from_seconds(duration_s);
    while (executor_.now() < end) {
      wheel_state_t base{};
      base.utime = to_utime(executor_.now());
      base.gate = gate_;
      send(channels::kWheelState, base);
      fusion::FusedPose pose;
      pose.stamp = executor_.now();
      pose.T_frame_body = pose_.to_pose();
      pose.frame = frame_;
      pose.status = fusion::Status::kOk;
      send(channels::kPose, fusion::to_wire(pose, 0));
      if (tracker_.path_sequence > 0) send(channels::kTrackerStatus, tracker_);
      executor_.run_until(executor_.now() + 100ms);
    }
  }
  /// Started, armed, in the world: the loop is ordered.
  void run_to_loop() {
    start();
    command(MissionCommand::kStart);
    gate_ = wheel_state_t::GATE_ARMED;
    frame_ = fusion::Frame::kWorld;
    run(0.5);
    ASSERT_EQ(state(), MissionState::kRunning);
    ASSERT_EQ(paths_.size(), 1U);
  }
  /// The tracker says that so much of the newest path is left.
  void track(double remaining_m) {
    tracker_.path_sequence = paths_.back().sequence;
    tracker_.mode = tracker_status_t::MODE_TRACK;
    tracker_.remaining_m = remaining_m;
    run(0.3);
  }
  MissionState state() const { return reports_.empty() ? MissionState::kWaiting : reports_.back().state; }
  static std::vector<Eigen::Vector2d> points_of(const path_t& path) {
    std::vector<Eigen::Vector2d> points;
    for (std::size_t i = 0; i < path.x_m.size(); ++i) points.emplace_back(path.x_m[i], path.y_m[i]);
    return points;
  }
  int count(std::int8_t action) const {
    int n = 0;
    for (const base_request_t& request : requests_) n += request.action == action ? 1 : 0;
    return n;
  }

  MissionConfig config_;
  LockstepExecutor executor_{Time(100s)};
  std::unique_ptr<MissionProcess> process_;
  Health* health_ = nullptr;
  Pose2 pose_{1.0, 2.4, 0.7};
  fusion::Frame frame_ = fusion::Frame::kOdom;
  std::int8_t gate_ = wheel_state_t::GATE_DISARMED;
  tracker_status_t tracker_{};
  std::vector<path_t> paths_;
  std::vector<base_request_t> requests_;
  std::vector<planning::MissionReport> reports_;
};

TEST_F(MissionProcessTest, BeforeTheStartItAsksForNothing) {
  start();
  frame_ = fusion::Frame::kWorld;
  run(3);
  EXPECT_TRUE(requests_.empty());
  EXPECT_TRUE(paths_.empty());
  EXPECT_EQ(state(), MissionState::kWaiting);
  EXPECT_GE(reports_.size(), 3U) << "once a second";
}

TEST_F(MissionProcessTest, ItArmsAlignsAndOrdersTheLoopFromWhereTheRobotStands) {
  start();
  command(MissionCommand::kStart);
  run(2.5);
  EXPECT_GE(count(base_request_t::ACTION_ARM), 2) << "asked again while nothing happens";
  EXPECT_EQ(state(), MissionState::kAligning);
  gate_ = wheel_state_t::GATE_ARMED;
  run(2);
  EXPECT_TRUE(paths_.empty()) << "armed, but not in the world";
  EXPECT_EQ(reports_.back().activity, "looking for the tag cube");
  frame_ = fusion::Frame::kWorld;
  run(0.3);
  ASSERT_EQ(paths_.size(), 1U);
  EXPECT_EQ(paths_[0].frame, "world");
  EXPECT_NEAR(paths_[0].x_m.front(), 1.0, 1e-9);
  EXPECT_NEAR(paths_[0].y_m.front(), 2.4, 1e-9);
  EXPECT_NEAR(paths_[0].x_m.back(), 4.9, 1e-9);
  EXPECT_NEAR(paths_[0].y_m.back(), 2.0, 1e-9);
  // A lap: 2 x (4 - 1.5) + 2 x (3 - 1.5) of straights, and a circle of 0.75 m; before it 3.9 m and a little more.
  EXPECT_NEAR(planning::length_m(points_of(paths_[0])), 8 + 2 * M_PI * 0.75 + 3.95, 0.1);
}

TEST_F(MissionProcessTest, ProgressIsThePathsAndAtItsEndTheBaseIsDisarmed) {
  run_to_loop();
  const double whole_m = planning::length_m(points_of(paths_[0]));
  EXPECT_NEAR(reports_.back().progress, 0, 1e-9) << "nothing is known of the path yet";
  track(0.25 * whole_m);
  run(1);
  EXPECT_NEAR(reports_.back().progress, 0.75, 1e-6);
  EXPECT_NEAR(reports_.back().left_s, 0.25 * whole_m / 0.5, 1e-6);
  tracker_.mode = tracker_status_t::MODE_ARRIVED;
  track(0);
  tracker_.mode = tracker_status_t::MODE_ARRIVED;
  run(0.3);
  EXPECT_EQ(state(), MissionState::kDone);
  EXPECT_TRUE(paths_.back().x_m.empty());
  EXPECT_EQ(count(base_request_t::ACTION_DISARM), 1);
}

TEST_F(MissionProcessTest, ArrivalOnAnotherPathIsNotTheEnd) {
  run_to_loop();
  track(5);
  tracker_.path_sequence = paths_.back().sequence - 1;
  tracker_.mode = tracker_status_t::MODE_ARRIVED;
  tracker_.remaining_m = 0;
  run(1);
  EXPECT_EQ(state(), MissionState::kRunning);
}

TEST_F(MissionProcessTest, APauseStopsAndTheRestIsDrivenAfterIt) {
  run_to_loop();
  track(6);
  command(MissionCommand::kPause);
  run(0.3);
  EXPECT_EQ(state(), MissionState::kPaused);
  EXPECT_TRUE(paths_.back().x_m.empty()) << "stop";
  tracker_.path_sequence = -1;  // the tracker follows nothing now
  tracker_.remaining_m = 0;
  run(2);
  const std::vector<Eigen::Vector2d> loop = points_of(paths_[0]);
  double left_m = 6;
  std::size_t here = loop.size() - 1;
  for (; left_m > 0; --here) left_m -= (loop[here] - loop[here - 1]).norm();
  pose_ = {loop[here].x(), loop[here].y(), 0};
  run(0.2);
  command(MissionCommand::kResume);
  run(0.5);
  EXPECT_EQ(state(), MissionState::kRunning);
  EXPECT_NEAR(planning::length_m(points_of(paths_.back())), 6, 0.15);
  EXPECT_NEAR(paths_.back().x_m.back(), 4.9, 1e-9);
}

TEST_F(MissionProcessTest, AnEmergencyStopPausesAndAfterItsReleaseTheBaseIsArmedAgain) {
  run_to_loop();
  track(6);
  const int armed = count(base_request_t::ACTION_ARM);
  gate_ = wheel_state_t::GATE_STOPPED;
  run(0.3);
  EXPECT_EQ(state(), MissionState::kPaused);
  EXPECT_THAT(reports_.back().reason, HasSubstr("emergency stop"));
  EXPECT_TRUE(paths_.back().x_m.empty());
  gate_ = wheel_state_t::GATE_DISARMED;
  run(3);
  EXPECT_EQ(state(), MissionState::kPaused) << "only a command goes on";
  EXPECT_EQ(count(base_request_t::ACTION_ARM), armed);
  EXPECT_EQ(count(base_request_t::ACTION_RELEASE), 0) << "that is an act of people beside the robot";
  command(MissionCommand::kResume);
  run(1.5);
  EXPECT_GT(count(base_request_t::ACTION_ARM), armed);
  EXPECT_FALSE(paths_.back().x_m.empty());
}

TEST_F(MissionProcessTest, AnAbortStopsDisarmsAndStays) {
  run_to_loop();
  command(MissionCommand::kAbort);
  run(0.3);
  EXPECT_EQ(state(), MissionState::kAborted);
  EXPECT_EQ(reports_.back().reason, "aborted by test");
  EXPECT_TRUE(paths_.back().x_m.empty());
  EXPECT_EQ(count(base_request_t::ACTION_DISARM), 1);
  command(MissionCommand::kStart);
  run(1);
  EXPECT_EQ(state(), MissionState::kAborted);
  EXPECT_THAT(health_->take_condition().message, HasSubstr("cannot start"));
}

TEST_F(MissionProcessTest, WhatTakesTooLongIsAborted) {
  config_.max_time_s = 5;
  start();
  command(MissionCommand::kStart);
  run(6);
  EXPECT_EQ(state(), MissionState::kAborted);
  EXPECT_THAT(reports_.back().reason, HasSubstr("max_time_s"));
}

TEST_F(MissionProcessTest, ItsOwnEndAbortsARunningMission) {
  run_to_loop();
  process_->finish();
  executor_.run_until(executor_.now() + 100ms);
  EXPECT_EQ(state(), MissionState::kAborted);
  EXPECT_TRUE(paths_.back().x_m.empty());
}

TEST_F(MissionProcessTest, GarbageIsCountedAndMovesNothing) {
  start();
  for (const char* channel :
       {channels::kMissionCommand, channels::kPose, channels::kWheelState, channels::kTrackerStatus}) {
    executor_.inject(executor_.now(), channel, Bytes(300, 0xAB));
    executor_.inject(executor_.now(), channel, Bytes{});
  }
  mission_command_t nonsense = planning::to_wire(executor_.now(), {MissionCommand::kStart, "test"});
  nonsense.command = 77;
  send(channels::kMissionCommand, nonsense);
  tracker_status_t endless{};
  endless.remaining_m = std::numeric_limits<double>::quiet_NaN();
  send(channels::kTrackerStatus, endless);
  wheel_state_t base{};
  base.gate = 9;
  send(channels::kWheelState, base);
  executor_.run_until(executor_.now() + 2s);
  EXPECT_EQ(health_->counter(channels::kMissionCommand, "undecodable"), 2);
  EXPECT_EQ(health_->counter(channels::kPose, "undecodable"), 2);
  EXPECT_EQ(health_->counter(channels::kMissionCommand, "invalid"), 1);
  EXPECT_EQ(health_->counter(channels::kTrackerStatus, "invalid"), 1);
  EXPECT_EQ(health_->counter(channels::kWheelState, "invalid"), 1);
  EXPECT_EQ(state(), MissionState::kWaiting);
  EXPECT_TRUE(paths_.empty());
  EXPECT_TRUE(requests_.empty());
}

TEST_F(MissionProcessTest, AMissionThatCannotBeIsOneClearError) {
  config_.loop.corner_radius_m = 9;
  EXPECT_THROW(start(), InputError);
  config_.loop.corner_radius_m = 0.5;
  config_.kind = "explore";
  EXPECT_THROW(start(), InputError) << "it needs a rig";
}

}  // namespace
}  // namespace arpent
