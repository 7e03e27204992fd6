// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Frames against the vectors of the vendor's manual.
#include "drivers/base/agilex_v2.h"

#include <gtest/gtest.h>

#include <random>

namespace arpent::base::agilex {
namespace {

TEST(AgilexV2, CommandsAreThoseOfTheManual) {
  EXPECT_EQ(can::to_text(encode_motion({0.15, 0})), "111#0096000000000000");
  EXPECT_EQ(can::to_text(encode_motion({0, 0.05})), "111#0000003200000000");
  EXPECT_EQ(can::to_text(encode_motion({-0.15, -0.05})), "111#FF6AFFCE00000000");
  EXPECT_EQ(can::to_text(encode_mode(Mode::kCan)), "421#01");
  EXPECT_EQ(can::to_text(encode_clear_errors()), "441#00");
}

TEST(AgilexV2, EveryFieldOfAReportHasItsPlace) {
  // Exception, remote control, 24.5 V, undervoltage warning and remote lost, count 9.
  const auto state = decode(*can::from_text("211#020300F506000009"));
  ASSERT_TRUE(state);
  const auto& s = std::get<SystemState>(*state);
  EXPECT_EQ(s.vehicle, VehicleState::kException);
  EXPECT_EQ(s.mode, Mode::kRemote);
  EXPECT_DOUBLE_EQ(s.battery_v, 24.5);
  EXPECT_FALSE(s.undervoltage_fault);
  EXPECT_TRUE(s.undervoltage_warning);
  EXPECT_TRUE(s.remote_lost);
  EXPECT_EQ(s.count, 9);
  const auto odometry = std::get<Odometry>(*decode(*can::from_text("311#000003E8FFFFFC17")));
  EXPECT_EQ(odometry.left_mm, 1000);
  EXPECT_EQ(odometry.right_mm, -1001);
  const auto motion = std::get<MotionState>(*decode(*can::from_text("221#0096FFCE00000000")));
  EXPECT_DOUBLE_EQ(motion.twist.speed_mps, 0.15);
  EXPECT_DOUBLE_EQ(motion.twist.turn_rate_radps, -0.05);
}

TEST(AgilexV2, BothSidesUnderstandEachOther) {
  const SystemState state{VehicleState::kEmergencyStop, Mode::kCan, 25.7, true, false, true, 77};
  EXPECT_EQ(std::get<SystemState>(*decode(encode(Report(state)))), state);
  const Odometry odometry{-2147483647 - 1, 2147483647};
  EXPECT_EQ(std::get<Odometry>(*decode(encode(Report(odometry)))), odometry);
  const MotionState motion{{1.234, -0.567}};
  EXPECT_EQ(std::get<MotionState>(*decode(encode(Report(motion)))), motion);
  EXPECT_EQ(*decode_motion(encode_motion({0.5, -1.0})), (Twist2{0.5, -1.0}));
  EXPECT_EQ(decode_mode(encode_mode(Mode::kCan)), Mode::kCan);
}

TEST(AgilexV2, GarbledFramesAreRefused) {
  for (const char* text : {"211#0201", "211#0300000000000000", "211#0004000000000000", "221#00", "311#0000",
                           "123#0000000000000000", "00000211#0000000000000000"}) {
    EXPECT_FALSE(decode(*can::from_text(text))) << text;
  }
  EXPECT_FALSE(decode_motion(*can::from_text("111#0096")));
  EXPECT_FALSE(decode_mode(*can::from_text("421#07")));
  EXPECT_FALSE(decode_mode(*can::from_text("421#")));
  std::mt19937 random(1);
  for (int i = 0; i < 20000; ++i) {
    can::CanFrame frame;
    frame.id = std::array{kSystemStateId, kMotionStateId, kOdometryId, kMotionCommandId, kModeCommandId}[random() % 5];
    frame.size = static_cast<std::uint8_t>(random() % 9);
    for (auto& byte : frame.data) byte = static_cast<std::uint8_t>(random());
    (void)decode(frame);
    (void)decode_motion(frame);
    (void)decode_mode(frame);
  }
}

}  // namespace
}  // namespace arpent::base::agilex
