// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// base_driver_process and a stand-in chassis in lockstep, on the robot's bus: every CAN frame is a message there.
#include "drivers/base/process/base_driver_process.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <arpent/can_frames_t.hpp>
#include <arpent/estop_t.hpp>
#include <filesystem>
#include <limits>

#include "common/atomic_file.h"
#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/robot.h"
#include "common/error.h"
#include "drivers/base/agilex_chassis.h"
#include "drivers/base/wire.h"
#include "drivers/can/candump.h"
#include "drivers/can/process/bus_port.h"
#include "drivers/can/wire.h"

namespace arpent {
namespace {

using testing::HasSubstr;

constexpr char kRobot[] = ARPENT_SOURCE_DIR "/config/robots/wifibot.yaml";
constexpr Duration kMs{1000};

/// The simulator's side: a chassis on the bus, moved on every 20 ms.
struct ChassisProcess {
  can::BusPort port;
  base::AgilexChassis chassis;

  explicit ChassisProcess(LockstepExecutor::Endpoint endpoint)
      : port("chassis", endpoint.bus, endpoint.clock), chassis({}, port) {
    endpoint.clock.every(20 * kMs, [this, &clock = endpoint.clock] { chassis.step(clock.now(), 0.02); });
  }
};

class BaseDriverProcessTest : public testing::Test {
 protected:
  BaseDriverProcessTest() {
    executor_.set_tap([this](Time time, const std::string& channel, BytesView bytes) { see(time, channel, bytes); });
  }

  static BaseDriverConfig config() {
    BaseDriverConfig config;
    config.robot = kRobot;
    config.port = "bus";
    return config;
  }
  void start(const BaseDriverConfig& config = BaseDriverProcessTest::config()) {
    const auto endpoint = executor_.add_process("base_driver_process");
    health_ = &endpoint.bus.health();
    process_ = std::make_unique<BaseDriverProcess>(config, endpoint.bus, endpoint.clock);
    chassis_ = std::make_unique<ChassisProcess>(executor_.add_process("chassis"));
  }

  void see(Time time, const std::string& channel, BytesView bytes) {
    std::string fault;
    if (channel == channels::kWheelState) {
      wheel_state_t message;
      ASSERT_TRUE(decode_guarded(bytes, message, fault)) << fault;
      const auto state = base::from_wire(message);
      ASSERT_TRUE(state) << state.fault();
      states_.push_back(*state);
    }
    if (channel == channels::kCan) {
      can_frames_t message;
      ASSERT_TRUE(decode_guarded(bytes, message, fault)) << fault;
      if (message.sender != "driver") return;
      const auto sent = can::from_wire(message);
      ASSERT_TRUE(sent) << sent.fault();
      for (const auto& frame : sent->frames) {
        if (const auto motion = base::agilex::decode_motion(frame)) motions_.emplace_back(time, *motion);
      }
    }
  }

  void command(Twist2 twist, Time stamp = {}) {
    executor_.inject(executor_.now(), channels::kWheelCommand, encode(base::to_wire({stamp, twist})));
  }
  void request(base::Action action) {
    executor_.inject(executor_.now(), channels::kBaseRequest, encode(base::to_wire({{}, action, "test"})));
  }
  void estop() {
    estop_t message{};
    message.source = "test";
    message.reason = "practice";
    executor_.inject(executor_.now(), channels::kEstop, encode(message));
  }
  void run(Duration duration) { executor_.run_until(executor_.now() + duration); }
  /// Commands at 20 Hz.
  void drive(Twist2 twist, Duration duration, Time stamp = {}) {
    for (const Time end = executor_.now() + duration; executor_.now() < end; run(50 * kMs)) command(twist, stamp);
  }
  void arm() {
    run(300 * kMs);
    request(base::Action::kArm);
    run(100 * kMs);
    ASSERT_EQ(states_.back().gate, base::GateState::kArmed);
  }
  double speed() const { return chassis_->chassis.twist().speed_mps; }
  /// When the newest motion command other than zero was sent.
  Time last_motion() const {
    Time last{};
    for (const auto& [time, twist] : motions_) {
      if (twist != Twist2{}) last = time;
    }
    return last;
  }

  LockstepExecutor executor_{from_utime(100'000'000)};
  std::unique_ptr<BaseDriverProcess> process_;
  std::unique_ptr<ChassisProcess> chassis_;
  Health* health_ = nullptr;
  std::vector<base::WheelState> states_;
  std::vector<std::pair<Time, Twist2>> motions_;
};

TEST_F(BaseDriverProcessTest, ItArmsDrivesAndReportsAtFiftyHertz) {
  start();
  arm();
  states_.clear();
  drive({0.4, 0.2}, 2000 * kMs);
  EXPECT_EQ(states_.size(), 100U);
  EXPECT_NEAR(speed(), 0.4, 1e-3);
  const base::WheelState& state = states_.back();
  EXPECT_TRUE(state.status.heard);
  EXPECT_NEAR(state.status.twist.turn_rate_radps, 0.2, 2e-3);
  EXPECT_EQ(state.status.commanded, (Twist2{0.4, 0.2}));
  // 2 s at 0.4 m/s less 0.1 s of lag and a cycle or two of delay.
  EXPECT_NEAR(0.5 * (state.status.left_m + state.status.right_m), 0.75, 0.02);
  EXPECT_EQ(state.fault, "");
  EXPECT_EQ(state.sequence, static_cast<std::int64_t>(states_.front().sequence + 99));
}

TEST_F(BaseDriverProcessTest, ItStartsDisarmedAndIgnoresCommandsThatFlow) {
  start();
  drive({0.4, 0}, 1000 * kMs);
  EXPECT_EQ(states_.back().gate, base::GateState::kDisarmed);
  request(base::Action::kArm);
  drive({0.4, 0}, 1000 * kMs);
  EXPECT_EQ(last_motion(), Time{}) << "commands were flowing: they must pause first";
  EXPECT_GT(health_->counter(channels::kWheelCommand, "refused"), 0);
}

TEST_F(BaseDriverProcessTest, SilenceStopsWithinTheDeadMansTimeWhateverTheStampsSay) {
  start();
  arm();
  const Time future = executor_.now() + std::chrono::hours(1);
  drive({0.4, 0}, 1000 * kMs, future);
  const Time last_command = executor_.now() - 50 * kMs;
  run(1000 * kMs);
  EXPECT_LE(last_motion() - last_command, 200 * kMs);
  EXPECT_GT(last_motion() - last_command, 150 * kMs);
  const auto zero =
      std::find_if(motions_.begin(), motions_.end(), [&](const auto& m) { return m.first > last_motion(); });
  EXPECT_EQ(zero->second, Twist2{});
  EXPECT_LE(zero->first - last_command, 205 * kMs) << "not only with the next cycle";
  EXPECT_LT(speed(), 0.02);
  EXPECT_GE(executor_.now() - motions_.back().first, Duration(0));
  EXPECT_LE(executor_.now() - motions_.back().first, 20 * kMs) << "zero is sent every cycle";
}

TEST_F(BaseDriverProcessTest, AnEmergencyStopIsOnTheCanBusAtOnceAndLatched) {
  start();
  arm();
  drive({0.4, 0}, 1000 * kMs);
  run(7 * kMs);  // between two cycles
  estop();
  const Time pressed = executor_.now();
  run(1 * kMs);
  EXPECT_EQ(motions_.back().first, pressed);
  EXPECT_EQ(motions_.back().second, Twist2{});
  drive({0.4, 0}, 1000 * kMs);
  EXPECT_LE(last_motion(), pressed);
  EXPECT_EQ(states_.back().gate, base::GateState::kStopped);
  EXPECT_THAT(states_.back().fault, HasSubstr("practice"));
  request(base::Action::kRelease);
  drive({0.4, 0}, 200 * kMs);
  EXPECT_EQ(states_.back().gate, base::GateState::kStopped) << "commands other than zero are coming in";
  drive({}, 500 * kMs);
  request(base::Action::kRelease);
  run(100 * kMs);
  EXPECT_EQ(states_.back().gate, base::GateState::kDisarmed) << "released is not armed";
  request(base::Action::kArm);
  run(100 * kMs);
  drive({0.4, 0}, 500 * kMs);
  EXPECT_GT(speed(), 0.35);
  EXPECT_EQ(states_.back().fault, "");
}

TEST_F(BaseDriverProcessTest, WhateverArrivesOnEstopStops) {
  start();
  arm();
  drive({0.4, 0}, 500 * kMs);
  executor_.inject(executor_.now(), channels::kEstop, Bytes(3, 0xAB));
  run(20 * kMs);
  EXPECT_EQ(states_.back().gate, base::GateState::kStopped);
  EXPECT_EQ(health_->counter(channels::kEstop, "undecodable"), 1);
}

TEST_F(BaseDriverProcessTest, ImpossibleCommandsAndGarbageAreCountedAndMoveNothing) {
  start();
  arm();
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const Twist2& bad : {Twist2{nan, 0}, Twist2{0, nan}, Twist2{inf, 0}, Twist2{0, -inf}}) {
    command(bad);
    run(50 * kMs);
  }
  for (const Twist2& bad : {Twist2{1e9, 0}, Twist2{0.6, 0}, Twist2{0, 1.1}, Twist2{0.1, -1e300}}) {
    command(bad);
    run(50 * kMs);
  }
  executor_.inject(executor_.now(), channels::kWheelCommand, Bytes(24, 0xFF));
  executor_.inject(executor_.now(), channels::kBaseRequest, Bytes(24, 0xFF));
  base_request_t unknown{};
  unknown.action = 77;
  executor_.inject(executor_.now(), channels::kBaseRequest, encode(unknown));
  run(500 * kMs);
  EXPECT_EQ(last_motion(), Time{});
  EXPECT_EQ(speed(), 0);
  EXPECT_EQ(health_->counter(channels::kWheelCommand, "invalid"), 4);
  EXPECT_EQ(health_->counter(channels::kWheelCommand, "refused"), 4);
  EXPECT_EQ(health_->counter(channels::kWheelCommand, "undecodable"), 1);
  EXPECT_EQ(health_->counter(channels::kBaseRequest, "undecodable"), 1);
  EXPECT_EQ(health_->counter(channels::kBaseRequest, "invalid"), 1);
  drive({0.4, 0}, 500 * kMs);
  EXPECT_GT(speed(), 0.35) << "and it goes on";
}

TEST_F(BaseDriverProcessTest, ADryRunListensAndSendsNothing) {
  BaseDriverConfig dry = config();
  dry.dry_run = true;
  start(dry);
  arm();
  drive({0.4, 0}, 500 * kMs);
  EXPECT_TRUE(motions_.empty());
  EXPECT_EQ(speed(), 0);
  EXPECT_TRUE(states_.back().status.heard);
  EXPECT_EQ(states_.back().status.commanded, (Twist2{0.4, 0}));
}

TEST_F(BaseDriverProcessTest, ACanLogHoldsWhatWasSentAndHeard) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "base_driver_can_log";
  BaseDriverConfig recording = config();
  recording.can_log = file;
  start(recording);
  arm();
  process_.reset();
  const auto frames = can::read_candump(file);
  const auto count = [&](std::uint32_t id) {
    return std::count_if(frames.begin(), frames.end(), [&](const auto& f) { return f.frame.id == id; });
  };
  EXPECT_EQ(count(base::agilex::kMotionCommandId), 20) << "400 ms of cycles";
  EXPECT_EQ(count(base::agilex::kOdometryId), 19);
  EXPECT_GE(count(base::agilex::kModeCommandId), 1);
  std::filesystem::remove(file);
}

TEST_F(BaseDriverProcessTest, ItCannotBeArmedWhileTheBaseDoesNotAnswer) {
  const auto endpoint = executor_.add_process("base_driver_process");
  BaseDriverProcess process(config(), endpoint.bus, endpoint.clock);
  run(300 * kMs);
  request(base::Action::kArm);
  run(100 * kMs);
  EXPECT_EQ(states_.back().gate, base::GateState::kDisarmed);
  EXPECT_EQ(endpoint.bus.health().counter(channels::kBaseRequest, "refused"), 1);
}

TEST_F(BaseDriverProcessTest, AnOrderlyEndLeavesTheBaseAtZero) {
  start();
  arm();
  drive({0.4, 0}, 500 * kMs);
  process_->finish();
  run(20 * kMs);
  EXPECT_EQ(motions_.back().second, Twist2{});
}

TEST_F(BaseDriverProcessTest, TheSameInputsGiveTheSameBytes) {
  const auto bytes_of_a_run = [] {
    std::vector<std::pair<std::string, Bytes>> seen;
    LockstepExecutor executor(from_utime(1'000'000), 2);
    executor.set_tap([&](Time, const std::string& channel, BytesView bytes) {
      seen.emplace_back(channel, Bytes(bytes.begin(), bytes.end()));
    });
    const auto endpoint = executor.add_process("base_driver_process");
    BaseDriverProcess process(config(), endpoint.bus, endpoint.clock);
    ChassisProcess chassis(executor.add_process("chassis"));
    executor.inject(from_utime(1'300'000), channels::kBaseRequest,
                    encode(base::to_wire({{}, base::Action::kArm, "test"})));
    for (int i = 0; i < 40; ++i) {
      executor.inject(from_utime(1'400'000 + 37'000 * i), channels::kWheelCommand,
                      encode(base::to_wire({{}, {0.01 * i, 0.02 * i}})));
    }
    executor.run_until(from_utime(3'000'000));
    return seen;
  };
  const auto first = bytes_of_a_run();
  EXPECT_GT(first.size(), 250U);
  EXPECT_EQ(first, bytes_of_a_run());
}

TEST(BaseDriverConfigTest, ARobotOrAPortThatCannotBeIsOneClearError) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "base_driver_config";
  std::filesystem::create_directories(folder);
  LockstepExecutor executor{Time()};
  const auto [bus, clock] = executor.add_process("p");
  const auto refusal = [&, &b = bus, &c = clock](const std::string& base_lines, const std::string& port) {
    const std::string text = "rig: rig.yaml\nbase:\n" + base_lines;
    atomic_write(folder / "robot.yaml", text);
    try {
      const BaseDriverProcess process({.robot = folder / "robot.yaml", .port = port, .can_log = {}, .dry_run = false},
                                      b, c);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refusal("  track_m: 0.5\n", "bus"), "accepted");
  EXPECT_THAT(refusal("  track_m: -0.5\n", "bus"), HasSubstr("robot.yaml:3: base.track_m"));
  EXPECT_THAT(refusal("  protocol: roomba\n", "bus"), HasSubstr("protocol"));
  EXPECT_THAT(refusal("  track_m: 0.5\n", "nonsense:port"), HasSubstr("nonsense:port"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace arpent
