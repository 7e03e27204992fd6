// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wire.h"

#include <gtest/gtest.h>

#include <limits>

namespace arpent::base {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Every field has a value of its own: a swap shows.
WheelState ramp() {
  WheelState state;
  state.sequence = 1;
  state.status.stamp = from_utime(2);
  state.status.left_m = 3;
  state.status.right_m = 4;
  state.status.twist = {5, 6};
  state.status.commanded = {7, 8};
  state.status.battery_v = 9;
  state.gate = GateState::kStopped;
  state.fault = "ten";
  return state;
}

TEST(BaseWire, EveryFieldOfTheStateComesBackInItsPlace) {
  const auto back = from_wire(to_wire(ramp()));
  ASSERT_TRUE(back) << back.fault();
  EXPECT_EQ(back->sequence, 1);
  EXPECT_EQ(back->status.stamp, from_utime(2));
  EXPECT_EQ(back->status.left_m, 3);
  EXPECT_EQ(back->status.right_m, 4);
  EXPECT_EQ(back->status.twist, (Twist2{5, 6}));
  EXPECT_EQ(back->status.commanded, (Twist2{7, 8}));
  EXPECT_EQ(back->status.battery_v, 9);
  EXPECT_EQ(back->gate, GateState::kStopped);
  EXPECT_EQ(back->fault, "ten");
  for (bool BaseStatus::*const flag :
       {&BaseStatus::heard, &BaseStatus::remote_control, &BaseStatus::emergency_button}) {
    WheelState state = ramp();
    state.status.*flag = true;
    const auto flagged = from_wire(to_wire(state));
    ASSERT_TRUE(flagged);
    EXPECT_TRUE(flagged->status.*flag);
    EXPECT_EQ(flagged->status.heard + flagged->status.remote_control + flagged->status.emergency_button, 1);
  }
}

TEST(BaseWire, ImpossibleStatesAreRefused) {
  const auto refused = [](auto damage) {
    wheel_state_t message = to_wire(ramp());
    damage(message);
    return !from_wire(message);
  };
  EXPECT_FALSE(refused([](auto&) {}));
  EXPECT_TRUE(refused([](auto& m) { m.left_m = kNan; }));
  EXPECT_TRUE(refused([](auto& m) { m.right_m = kNan; }));
  EXPECT_TRUE(refused([](auto& m) { m.speed_mps = kNan; }));
  EXPECT_TRUE(refused([](auto& m) { m.commanded_turn_rate_radps = kNan; }));
  EXPECT_TRUE(refused([](auto& m) { m.battery_v = kNan; }));
  EXPECT_TRUE(refused([](auto& m) { m.gate = 3; }));
  EXPECT_TRUE(refused([](auto& m) { m.gate = -1; }));
  EXPECT_TRUE(refused([](auto& m) { m.heard = 2; }));
}

TEST(BaseWire, CommandsAndRequestsComeBackAndImpossibleOnesAreRefused) {
  const auto command = from_wire(to_wire(WheelCommand{from_utime(1), {2, 3}}));
  ASSERT_TRUE(command);
  EXPECT_EQ(command->stamp, from_utime(1));
  EXPECT_EQ(command->twist, (Twist2{2, 3}));
  EXPECT_FALSE(from_wire(to_wire(WheelCommand{Time(), {kNan, 0}})));
  EXPECT_FALSE(from_wire(to_wire(WheelCommand{Time(), {0, kNan}})));
  for (const Action action : {Action::kArm, Action::kDisarm, Action::kRelease}) {
    const auto request = from_wire(to_wire(BaseRequest{from_utime(5), action, "me"}));
    ASSERT_TRUE(request);
    EXPECT_EQ(request->action, action);
    EXPECT_EQ(request->stamp, from_utime(5));
    EXPECT_EQ(request->source, "me");
  }
  base_request_t unknown{};
  EXPECT_FALSE(from_wire(unknown));
}

}  // namespace
}  // namespace arpent::base
