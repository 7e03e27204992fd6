// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/pacer.h"

#include <gtest/gtest.h>

namespace arpent::link {
namespace {

TEST(LinkPacer, ABurstLeavesNoFasterThanTheRate) {
  Pacer pacer(2.0);
  const Time start = from_utime(1'000'000);
  Time last;
  for (int i = 0; i < 101; ++i) last = pacer.next(start, 8000);
  // 8000 bytes are 8 frames: 8000 + 8 * 190 = 9520 bytes, 38.08 ms at 2 Mbit/s.
  EXPECT_NEAR(to_seconds(last - start), 100 * 0.03808, 1e-4);
}

TEST(LinkPacer, APieceAfterAPauseLeavesAtOnceAndSavesNothingUp) {
  Pacer pacer(2.0);
  EXPECT_EQ(pacer.next(from_utime(0), 8000), from_utime(0));
  EXPECT_EQ(pacer.next(from_utime(9'000'000), 8000), from_utime(9'000'000));
  EXPECT_EQ(pacer.next(from_utime(9'000'000), 8000), from_utime(9'038'080));
}

}  // namespace
}  // namespace arpent::link
