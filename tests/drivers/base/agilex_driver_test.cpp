// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The driver and the stand-in of the chassis on one bus, on a clock of the test's own.
#include "drivers/base/agilex_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "drivers/base/agilex_chassis.h"
#include "drivers/can/memory_bus.h"

namespace arpent::base {
namespace {

using testing::Contains;
using testing::HasSubstr;

class AgilexDriverTest : public testing::Test {
 protected:
  can::MemoryBus bus_;
  std::unique_ptr<can::CanPort> driver_port_ = bus_.open("driver"), chassis_port_ = bus_.open("chassis");
  AgilexDriver driver_{{}, *driver_port_};
  AgilexChassis chassis_{{.motors = {.max_acceleration_mps2 = 100}}, *chassis_port_};
  Time now_ = from_utime(1000000);
  std::vector<std::string> faults_;

  /// Cycles of 20 ms; `command` is offered anew in each if it is given.
  void run(int cycles, std::optional<Twist2> command = std::nullopt) {
    for (int i = 0; i < cycles; ++i) {
      now_ += from_seconds(0.02);
      bus_.advance(now_);
      if (command) (void)driver_.gate().offer(*command, now_);
      for (auto& fault : driver_.step(now_)) faults_.push_back(fault);
      bus_.advance(now_ + from_seconds(0.001));
      chassis_.step(now_, 0.02);
    }
  }
  void arm() {
    run(2);
    ASSERT_FALSE(driver_.gate().arm());
    run(5, Twist2{});
  }
};

TEST_F(AgilexDriverTest, ArmsDrivesAndMeasuresItsWay) {
  arm();
  EXPECT_EQ(chassis_.mode(), agilex::Mode::kCan);
  run(100, Twist2{0.5, 0.2});
  EXPECT_NEAR(chassis_.twist().speed_mps, 0.5, 1e-3);
  // 2 s at 0.5 m/s, less 0.1 s of lag.
  EXPECT_NEAR(0.5 * (driver_.status().left_m + driver_.status().right_m), 0.95, 0.03);
  EXPECT_NEAR((driver_.status().right_m - driver_.status().left_m) / 0.583, 0.38, 0.02);
  EXPECT_NEAR(driver_.status().twist.turn_rate_radps, 0.2, 2e-3);
  EXPECT_TRUE(driver_.status().heard);
  EXPECT_TRUE(faults_.empty());
}

TEST_F(AgilexDriverTest, WithoutCommandsItStandsWithinTheDeadMansTime) {
  arm();
  run(50, Twist2{0.5, 0});
  run(11);  // 200 ms and a cycle
  run(25);
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01);
  EXPECT_EQ(driver_.gate().state(), GateState::kArmed);
  run(50, Twist2{0.5, 0});
  EXPECT_GT(chassis_.twist().speed_mps, 0.4) << "and goes on when they come again";
}

TEST_F(AgilexDriverTest, APulledPlugStopsTheChassisByItselfAndIsReported) {
  arm();
  run(50, Twist2{0.5, 0});
  bus_.set_state("driver", can::PortState::kGone);
  run(70, Twist2{0.5, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01);
  EXPECT_FALSE(driver_.status().heard);
  EXPECT_GT(driver_.status().refused_sends, 0);
  EXPECT_THAT(faults_, Contains(HasSubstr("silent")));
  EXPECT_THAT(faults_, Contains(HasSubstr("not there")));
  EXPECT_EQ(driver_.gate().state(), GateState::kStopped);
  bus_.set_state("driver", can::PortState::kActive);
  run(50, Twist2{0.5, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01) << "back on the bus it does not start off by itself";
  EXPECT_TRUE(driver_.status().heard);
}

TEST_F(AgilexDriverTest, TheButtonLatchesAndTheRemoteControlIsReported) {
  arm();
  run(50, Twist2{0.5, 0});
  chassis_.press_emergency_button(true);
  run(30, Twist2{0.5, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.02);
  EXPECT_EQ(driver_.gate().state(), GateState::kStopped);
  chassis_.press_emergency_button(false);
  run(50, Twist2{0.5, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01) << "released at the chassis is not released here";
  EXPECT_THAT(faults_, Contains(HasSubstr("emergency button")));
  chassis_.take_remote_control(true);
  run(10);
  EXPECT_TRUE(driver_.status().remote_control);
  EXPECT_THAT(faults_, Contains(HasSubstr("remote control")));
}

TEST_F(AgilexDriverTest, ARestartedChassisIsTakenOverAgainAndItsWayGoesOn) {
  arm();
  run(100, Twist2{0.5, 0});
  const double before = driver_.status().left_m;
  chassis_.restart();
  run(50, Twist2{0.5, 0});
  EXPECT_GT(driver_.status().left_m, before);
  EXPECT_GT(chassis_.twist().speed_mps, 0.3);
  EXPECT_THAT(faults_, Contains(HasSubstr("set to zero")));
}

TEST_F(AgilexDriverTest, WhatTheRemoteControlGivesBackStands) {
  arm();
  run(50, Twist2{0.5, 0});
  chassis_.take_remote_control(true, {-0.2, 0});
  run(50, Twist2{0.5, 0});
  EXPECT_NEAR(chassis_.twist().speed_mps, -0.2, 0.01) << "the sticks drive";
  chassis_.take_remote_control(false);
  run(50, Twist2{0.5, 0});
  EXPECT_LT(std::abs(chassis_.twist().speed_mps), 0.01);
  EXPECT_EQ(driver_.gate().state(), GateState::kDisarmed);
}

TEST_F(AgilexDriverTest, AFloodOfFramesDoesNotKeepACycleFromItsCommand) {
  struct Flood : can::CanPort {
    bool send(const can::CanFrame&) override { return ++sent > 0; }
    std::optional<can::LoggedFrame> receive() override {
      return can::LoggedFrame{Time(), "x", *can::from_text("7FF#")};
    }
    can::PortState state() const override { return can::PortState::kActive; }
    can::PortCounters counters() const override { return {}; }
    int sent = 0;
  } flood;
  AgilexDriver driver({}, flood);
  (void)driver.step(now_);
  EXPECT_EQ(flood.sent, 1);
  EXPECT_EQ(driver.status().bad_frames, 0) << "frames of others";
}

TEST_F(AgilexDriverTest, BusOffStopsAndItsEndIsReported) {
  arm();
  run(50, Twist2{0.5, 0});
  bus_.set_state("driver", can::PortState::kBusOff);
  run(2, Twist2{0.5, 0});
  EXPECT_EQ(driver_.gate().state(), GateState::kStopped);
  EXPECT_THAT(faults_, Contains(HasSubstr("bus-off")));
  bus_.set_state("driver", can::PortState::kActive);
  run(2, Twist2{0.5, 0});
  EXPECT_THAT(faults_, Contains(HasSubstr("restarted")));
  EXPECT_EQ(driver_.gate().state(), GateState::kStopped);
}

TEST_F(AgilexDriverTest, APortThatIsNotThereAtTheStartIsOnlyReported) {
  bus_.set_state("driver", can::PortState::kGone);
  run(10);
  EXPECT_THAT(faults_, Contains(HasSubstr("not there")));
  bus_.set_state("driver", can::PortState::kActive);
  arm();
  run(50, Twist2{0.5, 0});
  EXPECT_GT(chassis_.twist().speed_mps, 0.4);
}

TEST_F(AgilexDriverTest, AChassisThatRepeatsItselfIsNotAlive) {
  const auto echo = bus_.open("echo");
  bus_.set_state("chassis", can::PortState::kGone);
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(echo->send(*can::from_text("211#000100FA00000007")));
    run(1);
  }
  EXPECT_FALSE(driver_.status().heard);
}

TEST_F(AgilexDriverTest, EncoderFaultsAreReportedWithinHalfASecondAndACycle) {
  arm();
  run(50, Twist2{0.5, 0});
  ASSERT_TRUE(faults_.empty());
  chassis_.motors().set_encoder_fault(Side::kLeft, EncoderFault::kStuck);
  chassis_.motors().set_encoder_fault(Side::kRight, EncoderFault::kReversed);
  run(27, Twist2{0.5, 0});
  EXPECT_THAT(faults_, Contains(HasSubstr("left odometer does not move")));
  EXPECT_THAT(faults_, Contains(HasSubstr("right odometer moves against")));
}

TEST_F(AgilexDriverTest, GarbledFramesAreCountedAndMoveNothing) {
  const auto noise = bus_.open("noise");
  for (const char* text : {"211#00", "211#0900000000000000", "311#0011"}) {
    EXPECT_TRUE(noise->send(*can::from_text(text)));
  }
  run(3);
  EXPECT_EQ(driver_.status().bad_frames, 3);
  EXPECT_EQ(chassis_.twist(), Twist2{});
  EXPECT_THROW(AgilexDriver({.gate = {}, .geometry = {.track_m = -1}}, *driver_port_), InputError);
}

}  // namespace
}  // namespace arpent::base
