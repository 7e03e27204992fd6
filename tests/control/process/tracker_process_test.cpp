// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// tracker_process on the in-memory bus, with a plant as the robot: it drives, and it stops for every reason to stop.
#include "control/process/tracker_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <arpent/body_pose_t.hpp>
#include <arpent/estop_t.hpp>
#include <arpent/path_t.hpp>
#include <arpent/tracker_status_t.hpp>
#include <arpent/wheel_command_t.hpp>
#include <arpent/wheel_state_t.hpp>
#include <cmath>
#include <limits>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "tests/control/plant.h"

namespace arpent {
namespace {

using control::BaseState;
using control::Plant;
using testing::HasSubstr;

constexpr double kCycleS = 0.02;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The robot sends its pose and its base's state every 20 ms; the tracker's newest command moves it.
class TrackerProcessTest : public testing::Test {
 protected:
  TrackerProcessTest() { start(false); }

  void start(bool dry_run) {
    executor_ = std::make_unique<LockstepExecutor>(Time(std::chrono::seconds(100)));
    plant_ = std::make_unique<Plant>(control::PlantParams{}, BaseState{executor_->now(), {0, 0}, 0, {}});
    TrackerConfig config;
    config.robot = ARPENT_SOURCE_DIR "/config/robots/wifibot.yaml";
    config.dry_run = dry_run;
    const auto [bus, clock] = executor_->add_process("tracker_process");
    tracker_ = std::make_unique<TrackerProcess>(config, bus, clock);
    health_ = &bus.health();
    executor_->set_tap([this](Time time, const std::string& channel, BytesView bytes) { see(time, channel, bytes); });
  }

  void see(Time time, const std::string& channel, BytesView bytes) {
    std::string fault;
    if (channel == channels::kWheelCommand) {
      wheel_command_t message;
      ASSERT_TRUE(decode_guarded(bytes, message, fault)) << fault;
      ++commands_;
      const Twist2 next{message.speed_mps, message.turn_rate_radps};
      EXPECT_LE(std::abs(next.speed_mps), 0.5 + 1e-12);
      EXPECT_LE(std::abs(next.turn_rate_radps), 1.0 + 1e-12);
      if (!forced_) {
        const double since_s = last_command_at_ ? to_seconds(time - *last_command_at_) : 0.04;
        EXPECT_LE(std::abs(next.speed_mps - command_.speed_mps), 0.5 * since_s + 1e-9);
        EXPECT_LE(std::abs(next.turn_rate_radps - command_.turn_rate_radps), 3.0 * since_s + 1e-9);
      }
      command_ = next;
      last_command_at_ = time;
    } else if (channel == channels::kTrackerStatus) {
      ASSERT_TRUE(decode_guarded(bytes, status_, fault)) << fault;
    }
  }

  template <class Message>
  void send(const char* channel, const Message& message) {
    executor_->inject(executor_->now(), channel, encode(message));
  }

  [[nodiscard]] body_pose_t pose() const {
    const BaseState& state = plant_->state();
    body_pose_t message{};
    message.utime = to_utime(state.stamp);
    message.frame = frame_;
    message.child_frame = "body";
    message.position_m[0] = state.p_map_m.x();
    message.position_m[1] = state.p_map_m.y();
    message.orientation_wxyz[0] = std::cos(state.yaw_rad / 2);
    message.orientation_wxyz[3] = std::sin(state.yaw_rad / 2);
    message.velocity_mps[0] = state.twist.speed_mps;
    message.angular_velocity_radps[2] = state.twist.turn_rate_radps;
    message.status = pose_status_;
    message.reason = pose_status_ == body_pose_t::STATUS_LOST ? "no idea" : "";
    return message;
  }

  void cycle() {
    wheel_state_t base{};
    base.utime = to_utime(plant_->state().stamp);
    base.gate = gate_;
    base.heard = 1;
    if (base_speaks_) send(channels::kWheelState, base);
    if (pose_speaks_) send(channels::kPose, pose());
    executor_->run_until(executor_->now() + from_seconds(kCycleS));
    plant_->move(command_, kCycleS);
  }
  void run(double duration_s) {
    for (double t = 0; t < duration_s - 1e-9; t += kCycleS) cycle();
  }

  [[nodiscard]] path_t path(std::vector<double> x_m, std::vector<double> y_m) {
    path_t message{};
    message.utime = to_utime(plant_->state().stamp);
    message.sequence = ++path_sequence_;
    message.frame = frame_;
    message.count = static_cast<std::int32_t>(x_m.size());
    message.x_m = std::move(x_m);
    message.y_m = std::move(y_m);
    return message;
  }
  void drive_up() {
    send(channels::kPath, path({0, 5}, {0, 0}));
    run(2);
    ASSERT_GT(plant_->state().twist.speed_mps, 0.4);
    ASSERT_EQ(status_.mode, tracker_status_t::MODE_TRACK);
    ASSERT_EQ(status_.path_sequence, path_sequence_);
  }
  /// Within a second and a half: 0.5 m/s at 0.5 m/s2, and the plant's delay.
  void expect_it_stops(const std::string& reason) {
    cycle();
    cycle();
    EXPECT_EQ(status_.mode, tracker_status_t::MODE_BRAKE);
    EXPECT_THAT(status_.reason, HasSubstr(reason));
    EXPECT_LT(command_.speed_mps, 0.49);
    run(1.5);
    EXPECT_EQ(command_, Twist2{});
    EXPECT_LT(std::abs(plant_->state().twist.speed_mps), 1e-3);
  }

  std::string frame_ = "world";
  std::int8_t gate_ = wheel_state_t::GATE_ARMED;
  std::int8_t pose_status_ = body_pose_t::STATUS_OK;
  bool pose_speaks_ = true, base_speaks_ = true;
  std::int64_t path_sequence_ = 6;
  bool forced_ = false;  ///< a hard stop is expected
  Twist2 command_;
  std::optional<Time> last_command_at_;
  int commands_ = 0;
  tracker_status_t status_{};
  std::unique_ptr<LockstepExecutor> executor_;
  std::unique_ptr<Plant> plant_;
  std::unique_ptr<TrackerProcess> tracker_;
  Health* health_ = nullptr;
};

TEST_F(TrackerProcessTest, ItDrivesThePathAndArrivesWithTheGoalHeading) {
  std::vector<double> x_m = {0}, y_m = {0};
  for (double a = 0; a <= 1.5; a += 0.05) {
    x_m.push_back(1 + 0.6 * std::sin(a));
    y_m.push_back(0.6 - 0.6 * std::cos(a));
  }
  const double x_goal = x_m.back(), y_goal = y_m.back();
  path_t message = path(x_m, y_m);
  message.has_goal_heading = 1;
  message.goal_heading_rad = 2.5;
  send(channels::kPath, message);
  run(12);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_ARRIVED);
  EXPECT_LT((plant_->state().p_map_m - Eigen::Vector2d(x_goal, y_goal)).norm(), 0.03);
  EXPECT_NEAR(plant_->state().yaw_rad, 2.5, 0.04);
  EXPECT_NEAR(commands_, 12 / 0.04, 3) << "every other pose";
}

TEST_F(TrackerProcessTest, WithoutAPathItSendsZero) {
  run(0.5);
  EXPECT_GT(commands_, 10);
  EXPECT_EQ(command_, Twist2{});
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_IDLE);
  EXPECT_EQ(status_.path_sequence, -1);
}

TEST_F(TrackerProcessTest, TheSpeedOfAPathIsKept) {
  path_t message = path({0, 5}, {0, 0});
  message.max_speed_mps = 0.2;
  send(channels::kPath, message);
  run(4);
  EXPECT_NEAR(plant_->state().twist.speed_mps, 0.2, 0.02);
}

TEST_F(TrackerProcessTest, ANewPathReplacesTheOldWithoutStopping) {
  drive_up();
  const Eigen::Vector2d at = plant_->state().p_map_m;
  send(channels::kPath, path({at.x(), at.x() + 0.5, at.x() + 3}, {0, 0, 0.3}));
  for (int i = 0; i < 50; ++i) {
    cycle();
    EXPECT_GT(plant_->state().twist.speed_mps, 0.4);
  }
  EXPECT_EQ(status_.path_sequence, path_sequence_);
}

TEST_F(TrackerProcessTest, AnEmptyPathStopsIt) {
  drive_up();
  send(channels::kPath, path({}, {}));
  run(1.6);
  EXPECT_EQ(command_, Twist2{});
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_IDLE);
  EXPECT_EQ(status_.path_sequence, -1);
}

TEST_F(TrackerProcessTest, AStalePoseStopsItBeforeTheDeadMansSwitchWould) {
  drive_up();
  pose_speaks_ = false;
  run(0.18);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_BRAKE);
  EXPECT_THAT(status_.reason, HasSubstr("stale"));
  run(1.5);
  EXPECT_LT(std::abs(plant_->state().twist.speed_mps), 1e-3);
  // And goes on when poses come again, from a stand.
  pose_speaks_ = true;
  run(1);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_TRACK);
  EXPECT_GT(plant_->state().twist.speed_mps, 0.2);
}

TEST_F(TrackerProcessTest, ALostPoseStopsItAndDeadReckoningDoesNot) {
  drive_up();
  pose_status_ = body_pose_t::STATUS_DEAD_RECKONING;
  run(0.5);
  EXPECT_GT(command_.speed_mps, 0.45);
  pose_status_ = body_pose_t::STATUS_LOST;
  expect_it_stops("lost: no idea");
}

TEST_F(TrackerProcessTest, APoseInAnotherFrameStopsIt) {
  drive_up();
  frame_ = "odom";
  expect_it_stops("the path is in world, the pose in odom");
}

TEST_F(TrackerProcessTest, ABaseThatIsNotArmedOrSilentStopsIt) {
  drive_up();
  gate_ = wheel_state_t::GATE_DISARMED;
  expect_it_stops("not armed");
  gate_ = wheel_state_t::GATE_ARMED;
  run(1);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_TRACK);
  base_speaks_ = false;
  run(0.5);
  expect_it_stops("the base is silent");
}

TEST_F(TrackerProcessTest, AnEmergencyStopIsAtOnceAndLastsUntilTheNextPath) {
  drive_up();
  estop_t stop{};
  stop.source = "test";
  stop.reason = "because";
  forced_ = true;
  send(channels::kEstop, stop);
  executor_->run_until(executor_->now() + from_seconds(0.001));
  EXPECT_EQ(command_, Twist2{});
  run(0.5);
  EXPECT_EQ(command_, Twist2{});
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_BRAKE);
  EXPECT_EQ(status_.reason, "emergency stop by test: because");
  EXPECT_EQ(status_.path_sequence, -1);
  forced_ = false;
  const double x = plant_->state().p_map_m.x();
  send(channels::kPath, path({x, x + 2}, {0, 0}));
  run(0.5);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_TRACK);
  EXPECT_GT(command_.speed_mps, 0.1);
}

TEST_F(TrackerProcessTest, BadPosesAreCountedAndStopItLikeSilence) {
  drive_up();
  pose_speaks_ = false;
  const auto bad = [&](const std::function<void(body_pose_t&)>& damage) {
    body_pose_t message = pose();
    message.utime += health_->counter(channels::kPose, "invalid") + 1;
    damage(message);
    const std::int64_t before = health_->counter(channels::kPose, "invalid");
    send(channels::kPose, message);
    executor_->run_until(executor_->now() + from_seconds(0.0001));
    EXPECT_EQ(health_->counter(channels::kPose, "invalid"), before + 1);
  };
  bad([](body_pose_t& m) { m.position_m[0] = kNan; });
  bad([](body_pose_t& m) { m.position_m[1] = 1e300; });
  bad([](body_pose_t& m) { m.orientation_wxyz[0] = 2; });
  bad([](body_pose_t& m) { m.velocity_mps[0] = kNan; });
  bad([](body_pose_t& m) { m.angular_velocity_radps[2] = kNan; });
  bad([](body_pose_t& m) { m.frame = "map"; });
  bad([](body_pose_t& m) { m.child_frame = "cam0"; });
  bad([](body_pose_t& m) { m.status = 7; });
  bad([](body_pose_t& m) { m.utime -= 1000000; });
  executor_->inject(executor_->now(), channels::kPose, Bytes(40, 0x5A));
  run(0.2);
  EXPECT_EQ(health_->counter(channels::kPose, "undecodable"), 1);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_BRAKE);
  run(1.5);
  EXPECT_EQ(command_, Twist2{});
}

TEST_F(TrackerProcessTest, ABadPathIsRefusedAndStopsTheOldOne) {
  const std::function<void(path_t&)> damages[] = {
      [](path_t& m) { m.x_m[1] = kNan; },
      [](path_t& m) { m.y_m[0] = 1e300; },
      [](path_t& m) { m.frame = "body"; },
      [](path_t& m) { m.max_speed_mps = kNan; },
      [](path_t& m) { m.has_goal_heading = 1, m.goal_heading_rad = kNan; },
      [](path_t& m) { m.x_m[1] = 1e5; },
      [](path_t& m) { m.x_m.resize(1), m.y_m.resize(1), m.count = 1; },
  };
  for (const auto& damage : damages) {
    command_ = {};
    last_command_at_.reset();
    start(false);
    drive_up();
    path_t message = path({0, 5}, {0, 0});
    damage(message);
    send(channels::kPath, message);
    run(1.6);
    EXPECT_EQ(health_->counter(channels::kPath, "invalid"), 1);
    EXPECT_EQ(command_, Twist2{});
    EXPECT_EQ(status_.mode, tracker_status_t::MODE_IDLE);
  }
}

TEST_F(TrackerProcessTest, APathOlderThanTheOneFollowedChangesNothing) {
  drive_up();
  path_t message = path({0, 0}, {0, 5});
  message.utime -= 10000000;
  send(channels::kPath, message);
  run(0.2);
  EXPECT_EQ(health_->counter(channels::kPath, "invalid"), 1);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_TRACK);
  EXPECT_GT(command_.speed_mps, 0.45);
}

TEST_F(TrackerProcessTest, ADryRunPublishesStatusOnly) {
  start(true);
  send(channels::kPath, path({0, 5}, {0, 0}));
  run(0.5);
  EXPECT_EQ(commands_, 0);
  EXPECT_EQ(status_.mode, tracker_status_t::MODE_TRACK);
  tracker_->finish();
  run(0.1);
  EXPECT_EQ(commands_, 0);
}

TEST_F(TrackerProcessTest, TheEndTellsTheBaseToStand) {
  drive_up();
  forced_ = true;
  pose_speaks_ = false;
  tracker_->finish();
  cycle();
  EXPECT_EQ(command_, Twist2{});
}

TEST_F(TrackerProcessTest, ARobotFileThatIsNotThereIsOneClearError) {
  TrackerConfig config;
  config.robot = "/nowhere/robot.yaml";
  const auto [bus, clock] = executor_->add_process("other");
  EXPECT_THROW(TrackerProcess(config, bus, clock), InputError);
}

}  // namespace
}  // namespace arpent
