// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/odometer.h"

#include <gtest/gtest.h>

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

TEST(Odometer, AWheelThatDoesNotMoveOrMovesBackwardsIsFound) {
  for (const int step : {0, -10}) {
    Odometer odometer(1e-3, 1.0);
    OdometerFault fault = OdometerFault::kNone;
    std::int64_t found_ms = -1;
    for (int i = 0; i < 100; ++i) {
      fault = odometer.update(1000 + step * i, 0.5, at_ms(20 * i));
      if (fault != OdometerFault::kNone && found_ms < 0) found_ms = 20 * i;
    }
    EXPECT_EQ(fault, step == 0 ? OdometerFault::kStuck : OdometerFault::kReversed);
    EXPECT_GT(found_ms, 500) << "lag is allowed for";
    EXPECT_LT(found_ms, 1000);
  }
}

}  // namespace
}  // namespace arpent::base
