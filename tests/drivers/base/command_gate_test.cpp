// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/command_gate.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace arpent::base {
namespace {

Time at_ms(std::int64_t ms) {
  return from_utime(1000 * ms);
}

CommandGate armed() {
  CommandGate gate{{}};
  EXPECT_FALSE(gate.arm());
  EXPECT_FALSE(gate.offer({}, at_ms(0)));
  return gate;
}

TEST(CommandGate, ItStartsDisarmedAndLetsNothingThrough) {
  CommandGate gate{{}};
  EXPECT_TRUE(gate.offer({0.2, 0}, at_ms(0)));
  EXPECT_EQ(gate.output(at_ms(1)), Twist2{});
  EXPECT_EQ(gate.state(), GateState::kDisarmed);
}

TEST(CommandGate, ACommandCountsForItsLifetimeAndNoLonger) {
  CommandGate gate = armed();
  ASSERT_FALSE(gate.offer({0.3, -0.2}, at_ms(100)));
  EXPECT_EQ(gate.output(at_ms(100)), (Twist2{0.3, -0.2}));
  EXPECT_EQ(gate.output(at_ms(300)), (Twist2{0.3, -0.2}));
  EXPECT_EQ(gate.output(at_ms(301)), Twist2{});
  EXPECT_EQ(gate.output(at_ms(99)), Twist2{}) << "a clock that went back moves nothing";
}

TEST(CommandGate, CommandsThatFlowWhileItIsArmedMustPauseFirst) {
  CommandGate gate{{}};
  EXPECT_TRUE(gate.offer({0.3, 0}, at_ms(0)));
  ASSERT_FALSE(gate.arm());
  EXPECT_TRUE(gate.offer({0.3, 0}, at_ms(10)));
  EXPECT_EQ(gate.output(at_ms(10)), Twist2{});
  EXPECT_FALSE(gate.offer({}, at_ms(20)));
  EXPECT_FALSE(gate.offer({0.3, 0}, at_ms(30)));
  EXPECT_EQ(gate.output(at_ms(30)).speed_mps, 0.3);
}

TEST(CommandGate, ImpossibleCommandsAreRefusedAndTheLastGoodOneRunsOut) {
  CommandGate gate = armed();
  ASSERT_FALSE(gate.offer({0.3, 0}, at_ms(100)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Twist2& bad : {Twist2{nan, 0}, Twist2{0, nan}, Twist2{1e9, 0}, Twist2{0.51, 0}, Twist2{0, -1.01}}) {
    EXPECT_TRUE(gate.offer(bad, at_ms(150)));
  }
  EXPECT_EQ(gate.output(at_ms(299)).speed_mps, 0.3);
  EXPECT_EQ(gate.output(at_ms(301)).speed_mps, 0);
}

TEST(CommandGate, TheEmergencyStopIsLatchedUntilALocalActWithZeroCommands) {
  CommandGate gate = armed();
  ASSERT_FALSE(gate.offer({0.3, 0}, at_ms(100)));
  gate.stop();
  EXPECT_EQ(gate.output(at_ms(101)), Twist2{});
  EXPECT_TRUE(gate.offer({0.3, 0}, at_ms(110)));
  EXPECT_TRUE(gate.arm()) << "not while it is stopped";
  EXPECT_TRUE(gate.release(at_ms(120))) << "commands are still flowing";
  EXPECT_EQ(gate.state(), GateState::kStopped);
  EXPECT_TRUE(gate.offer({}, at_ms(130)));
  EXPECT_FALSE(gate.release(at_ms(140)));
  EXPECT_EQ(gate.state(), GateState::kDisarmed) << "released is not armed";
  EXPECT_EQ(gate.output(at_ms(141)), Twist2{});
}

TEST(CommandGate, WhatWaitedWhileTheDriverSleptMovesNothing) {
  for (const bool looks_first : {true, false}) {
    CommandGate gate = armed();
    for (std::int64_t ms = 0; ms <= 100; ms += 5) gate.watch(at_ms(ms));
    ASSERT_FALSE(gate.offer({0.3, 0}, at_ms(100)));
    // Asleep for 120 ms: even the last command, still within its lifetime, is over, and what waited is refused.
    if (looks_first) gate.watch(at_ms(220));
    EXPECT_TRUE(gate.offer({0.2, 0}, at_ms(220)));
    gate.watch(at_ms(221));
    EXPECT_EQ(gate.output(at_ms(221)), Twist2{});
    for (std::int64_t ms = 225; ms <= 425; ms += 5) {
      gate.watch(at_ms(ms));
      if (ms <= 420) {
        EXPECT_TRUE(gate.offer({0.2, 0}, at_ms(ms))) << ms;
      }
      EXPECT_EQ(gate.output(at_ms(ms)), Twist2{});
    }
    gate.watch(at_ms(430));
    EXPECT_FALSE(gate.offer({0.1, 0}, at_ms(430))) << "fresh again";
    EXPECT_EQ(gate.output(at_ms(430)).speed_mps, 0.1);
  }
}

TEST(CommandGate, ABriefHiccupOfTheDriverCostsNoCommand) {
  CommandGate gate = armed();
  gate.watch(at_ms(0));
  ASSERT_FALSE(gate.offer({0.3, 0}, at_ms(10)));
  gate.watch(at_ms(100));
  EXPECT_EQ(gate.output(at_ms(100)).speed_mps, 0.3);
  EXPECT_FALSE(gate.offer({0.2, 0}, at_ms(101)));
}

TEST(CommandGate, NothingMovesUnlessArmedFreshAndWithinLimitsWhateverHappens) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  CommandGate gate{{}};
  std::int64_t now = 0, last_accepted = -1000000;
  bool stopped = false;
  for (int i = 0; i < 200000; ++i) {
    now += static_cast<std::int64_t>(random() % 80);
    switch (random() % 8) {
      case 0:
        (void)gate.arm();
        break;
      case 1:
        if (random() % 8 == 0) gate.disarm();
        break;
      case 2:
        if (random() % 8 == 0) {
          gate.stop();
          stopped = true;
        }
        break;
      case 3:
        if (!gate.release(at_ms(now))) stopped = false;
        break;
      case 4:
        if (!gate.offer({}, at_ms(now))) last_accepted = now;
        break;
      default:
        if (!gate.offer({0.4 * uniform(random), uniform(random)}, at_ms(now))) last_accepted = now;
        break;
    }
    const Twist2 out = gate.output(at_ms(now));
    if (out == Twist2{}) continue;
    ASSERT_FALSE(stopped);
    ASSERT_EQ(gate.state(), GateState::kArmed);
    ASSERT_LE(now - last_accepted, 200);
    ASSERT_LE(std::abs(out.speed_mps), 0.5 + 1e-5);
    ASSERT_LE(std::abs(out.turn_rate_radps), 1.0 + 1e-5);
  }
}

}  // namespace
}  // namespace arpent::base
