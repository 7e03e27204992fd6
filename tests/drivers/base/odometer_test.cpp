// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/odometer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace arpent::base {
namespace {

Time at_ms(std::int64_t ms) {
  return from_utime(1000 * ms);
}

TEST(Odometer, AddsUpAcrossTheWrap) {
  Odometer odometer(1e-3, 1.0);
  std::int32_t count = std::numeric_limits<std::int32_t>::max() - 25;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(odometer.update(count, 0.5, at_ms(20 * i)), OdometerFault::kNone);
    count = static_cast<std::int32_t>(static_cast<std::uint32_t>(count) + 10U);
  }
  EXPECT_NEAR(odometer.way_m(), 0.09, 1e-9);
}

TEST(Odometer, AResetAndAJumpAreToldAndLeftOut) {
  Odometer odometer(1e-3, 1.0);
  (void)odometer.update(50000, 0, at_ms(0));
  EXPECT_EQ(odometer.update(50010, 0.5, at_ms(20)), OdometerFault::kNone);
  EXPECT_EQ(odometer.update(3, 0.5, at_ms(40)), OdometerFault::kReset);
  EXPECT_EQ(odometer.update(13, 0.5, at_ms(60)), OdometerFault::kNone);
  EXPECT_EQ(odometer.update(9000, 0.5, at_ms(80)), OdometerFault::kJump);
  EXPECT_EQ(odometer.update(9010, 0.5, at_ms(100)), OdometerFault::kNone);
  EXPECT_NEAR(odometer.way_m(), 0.03, 1e-9);
}

/// When the fault is found in readings every 20 ms that begin with a second of good driving [ms after its start]; -1 if
/// never within 2 s.
std::int64_t found_after_ms(double speed_mps, double gain, OdometerFault expected) {
  Odometer odometer(1e-3, 1.0);
  double way_m = 0;
  for (int i = 0; i < 150; ++i) {
    way_m += (i <= 50 ? 1 : gain) * speed_mps * 0.02;
    const OdometerFault fault =
        odometer.update(static_cast<std::int32_t>(std::floor(1e3 * way_m)), speed_mps, at_ms(20 * i));
    EXPECT_TRUE(i > 50 || fault == OdometerFault::kNone) << i;
    if (fault == expected) return 20 * (i - 50);
  }
  return -1;
}

TEST(Odometer, AWheelThatDoesNotMoveOrMovesBackwardsIsFoundWithinHalfASecond) {
  for (const double speed_mps : {0.12, 0.5, -0.3}) {
    for (const double gain : {0.0, 0.03}) {
      const std::int64_t ms = found_after_ms(speed_mps, gain, OdometerFault::kStuck);
      EXPECT_GT(ms, 200) << "lag is allowed for";
      EXPECT_LE(ms, 520) << speed_mps << " " << gain;
    }
    EXPECT_LE(found_after_ms(speed_mps, -1, OdometerFault::kReversed), 520);
    EXPECT_GT(found_after_ms(speed_mps, -1, OdometerFault::kReversed), 0);
  }
}

TEST(Odometer, LagAndTurningRoundAreNoFaults) {
  Odometer odometer(1e-3, 1.0);
  double way_m = 0, speed_mps = 0;
  for (int i = 0; i < 500; ++i) {
    const double told_mps = i / 75 % 2 == 0 ? 0.5 : -0.5;  // turns round every 1.5 s
    speed_mps += (told_mps - speed_mps) * (1 - std::exp(-0.02 / 0.2));
    way_m += speed_mps * 0.02;
    EXPECT_EQ(odometer.update(static_cast<std::int32_t>(std::floor(1e3 * way_m)), told_mps, at_ms(20 * i)),
              OdometerFault::kNone)
        << i;
  }
}

}  // namespace
}  // namespace arpent::base
