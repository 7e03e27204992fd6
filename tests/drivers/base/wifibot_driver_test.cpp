// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The driver and the stand-in of the board on a line in memory, on a clock of the test's own.
#include "drivers/base/wifibot_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "common/error.h"
#include "drivers/base/wifibot_chassis.h"

namespace arpent::base {
namespace {

using testing::Contains;
using testing::HasSubstr;
using Bytes = std::vector<std::uint8_t>;

/// Both directions of a line.
struct Line : BytePort {
  Bytes to_board, to_driver;
  bool plugged = true;

  bool send(std::span<const std::uint8_t> bytes) override {
    if (plugged) to_board.insert(to_board.end(), bytes.begin(), bytes.end());
    return plugged;
  }
  Bytes receive() override { return plugged ? std::exchange(to_driver, {}) : Bytes{}; }
  bool open() const override { return plugged; }
  std::string fault() const override { return "unplugged"; }
};

class WifibotDriverTest : public testing::Test {
 protected:
  Line line_;
  WifibotChassis chassis_{{.motors = {.geometry = {.track_m = 0.3}, .counts_per_m = 5312}}};
  DriverParams params_{.geometry = {.track_m = 0.3}};
  WifibotDriver driver_{params_, {}, line_};
  Time now_ = from_utime(1000000);
  std::vector<std::string> faults_;
  double noise_ = 0;
  std::mt19937 random_{1};

  void run(int cycles, std::optional<Twist2> command = std::nullopt) {
    for (int i = 0; i < cycles; ++i) {
      now_ += kCycle;
      if (command) (void)driver_.gate().offer(*command, now_);
      for (auto& fault : driver_.step(now_)) faults_.push_back(fault);
      chassis_.receive(std::exchange(line_.to_board, {}), now_);
      chassis_.step(now_, to_seconds(kCycle));
      for (std::uint8_t byte : chassis_.telemetry()) {
        if (std::uniform_real_distribution<double>()(random_) < noise_) byte ^= 0x40;
        line_.to_driver.push_back(byte);
      }
    }
  }
  void arm() {
    run(5);
    ASSERT_FALSE(driver_.gate().arm());
    run(5, Twist2{});
  }
};

TEST_F(WifibotDriverTest, ArmsDrivesAndMeasuresItsWay) {
  arm();
  run(100, Twist2{0.4, 0.5});
  EXPECT_NEAR(chassis_.twist().speed_mps, 0.4, 3e-3) << "to a tick of the command";
  EXPECT_NEAR(driver_.status().twist.speed_mps, 0.4, 5e-3);
  EXPECT_NEAR(driver_.status().twist.turn_rate_radps, 0.5, 0.02);
  EXPECT_NEAR(0.5 * (driver_.status().left_m + driver_.status().right_m), 0.74, 0.03);
  EXPECT_NEAR((driver_.status().right_m - driver_.status().left_m) / 0.3, 0.94, 0.05);
  EXPECT_DOUBLE_EQ(driver_.status().battery_v, 12.5);
  EXPECT_TRUE(faults_.empty());
}

TEST_F(WifibotDriverTest, TheDeadManAndTheEmergencyStopStopIt) {
  arm();
  run(50, Twist2{0.4, 0});
  run(11);
  run(25);
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01);
  run(50, Twist2{0.4, 0});
  driver_.stop();
  chassis_.receive(std::exchange(line_.to_board, {}), now_);
  chassis_.step(now_, 1.0);
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01) << "without another cycle of the driver";
  run(50, Twist2{0.4, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01) << "it is latched";
}

TEST_F(WifibotDriverTest, TheBoardsWatchdogStopsItWhenThePlugIsPulled) {
  arm();
  run(50, Twist2{0.4, 0});
  line_.plugged = false;
  run(50, Twist2{0.4, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01);
  EXPECT_EQ(driver_.gate().state(), GateState::kStopped);
  EXPECT_THAT(faults_, Contains(HasSubstr("unplugged")));
  line_.plugged = true;
  run(50, Twist2{0.4, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01) << "it does not start off by itself";
}

TEST_F(WifibotDriverTest, FlippedBitsAreCountedAndLeaveTheWayAlone) {
  arm();
  noise_ = 0.02;
  run(100, Twist2{0.4, 0});
  noise_ = 0;
  run(10, Twist2{0.4, 0});
  EXPECT_GT(driver_.status().bad_frames, 0);
  EXPECT_NEAR(driver_.status().left_m, 0.8, 0.1);
}

TEST_F(WifibotDriverTest, APidFrameZeroesTheCountersAndTheWayGoesOn) {
  arm();
  run(100, Twist2{0.4, 0});
  const double before = driver_.status().left_m;
  chassis_.receive(wifibot::encode(wifibot::PidCommand{}), now_);
  EXPECT_EQ(chassis_.motors().count(Side::kLeft), 0);
  run(50, Twist2{0.4, 0});
  EXPECT_GT(driver_.status().left_m, before + 0.3);
  EXPECT_THAT(faults_, Contains(HasSubstr("set to zero")));
}

TEST(WifibotDriver, ItWakesABoardThatIsSilentOnlyIfItIsToldTo) {
  for (const bool wake : {false, true}) {
    Line line;
    WifibotDriver driver({}, {.wake_by_pid = wake}, line);
    for (int i = 0; i < 60; ++i) (void)driver.step(from_utime(1000000 + 20000 * i));
    const auto pid = wifibot::encode(wifibot::PidCommand{});
    int found = 0;
    for (auto at = line.to_board.begin();; ++found, ++at) {
      at = std::search(at, line.to_board.end(), pid.begin(), pid.end());
      if (at == line.to_board.end()) break;
    }
    EXPECT_EQ(found, wake ? 2 : 0) << "once a second";
  }
}

TEST(WifibotDriver, LimitsBeyondWhatTheBoardTakesAreRefusedAtTheStart) {
  Line line;
  EXPECT_THROW(WifibotDriver({.gate = {.limits = {.max_speed_mps = 1.0}}}, {}, line), InputError);
  EXPECT_THROW(WifibotDriver({}, {.odometer_ticks_per_m = -1}, line), InputError);
}

TEST(WifibotChassis, ItBootsStreamingAndTurnsClassicAtTheFirstSyncByte) {
  WifibotChassis chassis({});
  EXPECT_EQ(chassis.telemetry()[0], 0xFE);
  wifibot::Parser parser;
  const auto reports = parser.feed(chassis.telemetry());
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<wifibot::Stream>(reports[0]));
  chassis.receive(wifibot::encode_stream({120, -120}), from_utime(1));
  chassis.step(from_utime(1), 10);
  EXPECT_NEAR(chassis.motors().speed_mps(Side::kLeft), 120 / 265.6, 1e-3);
  EXPECT_NEAR(chassis.motors().speed_mps(Side::kRight), -120 / 265.6, 1e-3);
  EXPECT_EQ(chassis.telemetry()[0], 0xFE);
  chassis.receive(wifibot::encode(wifibot::SpeedCommand{}), from_utime(1));
  EXPECT_EQ(chassis.telemetry()[0], 0xFF);
}

TEST(WifibotChassis, TheWatchdogCanBeSetAndCommandsMayComeInPieces) {
  WifibotChassis chassis({});
  chassis.receive(wifibot::encode_watchdog(50), from_utime(0));
  const auto command = wifibot::encode(wifibot::SpeedCommand{100, 100});
  for (const std::uint8_t byte : command) chassis.receive(std::span(&byte, 1), from_utime(0));
  chassis.step(from_utime(400'000), 1.0);
  EXPECT_GT(chassis.twist().speed_mps, 0.3);
  chassis.step(from_utime(501'000), 1.0);
  EXPECT_LT(chassis.twist().speed_mps, 0.01);
}

}  // namespace
}  // namespace arpent::base
