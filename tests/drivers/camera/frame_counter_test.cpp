// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/frame_counter.h"

#include <gtest/gtest.h>

#include <random>

namespace arpent::camera {
namespace {

using Step = FrameCounter::Step;

TEST(CameraFrameCounter, GigeIdsRunFrom65535To1WithoutAGap) {
  FrameCounter counter;
  (void)counter.read(65534, 65535);
  EXPECT_EQ(counter.read(65535, 65535).count, 1);
  const auto wrapped = counter.read(1, 65535);
  EXPECT_EQ(wrapped.step, Step::kForward);
  EXPECT_EQ(wrapped.count, 2);
  EXPECT_EQ(wrapped.missed, 0);
}

TEST(CameraFrameCounter, FramesMissedAcrossTheWrapAreCounted) {
  FrameCounter counter;
  (void)counter.read(65533, 65535);
  const auto reading = counter.read(3, 65535);  // 65534, 65535, 1, 2 are missing
  EXPECT_EQ(reading.missed, 4);
  EXPECT_EQ(reading.count, 5);
}

TEST(CameraFrameCounter, IdsBeyondThePeriodAreExtendedOnesAndDoNotWrap) {
  FrameCounter counter;
  (void)counter.read(65535, 65535);
  EXPECT_EQ(counter.read(65536, 65535).missed, 0);
  EXPECT_EQ(counter.read(65537, 65535).count, 2);
}

TEST(CameraFrameCounter, ARepeatedIdIsAFrozenDeviceAndAnOlderOneWasOvertaken) {
  FrameCounter counter;
  (void)counter.read(10, 0);
  EXPECT_EQ(counter.read(10, 0).step, Step::kRepeated);
  EXPECT_EQ(counter.read(9, 0).step, Step::kBackward);
  EXPECT_EQ(counter.read(11, 0).count, 1) << "neither changed the count";
}

TEST(CameraFrameCounter, AFarStepBackIsARestartedDevice) {
  FrameCounter counter;
  (void)counter.read(5000, 0);
  EXPECT_EQ(counter.read(1, 0).step, Step::kRestarted);
}

TEST(CameraFrameCounter, CountsLikeACounterThatNeverWraps) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> step(1, 200);
  FrameCounter counter;
  std::int64_t truth = 60000;
  const auto as_sent = [](std::int64_t n) { return (n - 1) % 65535 + 1; };
  const std::int64_t start = truth;
  (void)counter.read(as_sent(truth), 65535);
  for (int i = 0; i < 5000; ++i) {
    const int by = step(random);
    truth += by;
    const auto reading = counter.read(as_sent(truth), 65535);
    ASSERT_EQ(reading.count, truth - start);
    ASSERT_EQ(reading.missed, by - 1);
  }
}

}  // namespace
}  // namespace arpent::camera
