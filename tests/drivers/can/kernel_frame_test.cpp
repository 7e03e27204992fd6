// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/kernel_frame.h"

#include <gtest/gtest.h>
#include <linux/can/error.h>

#include <random>

namespace arpent::can {
namespace {

TEST(KernelFrame, FramesComeBackAsTheyWere) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    CanFrame frame;
    frame.extended = random() % 2 == 0;
    frame.id = random() & (frame.extended ? kLargestExtendedId : kLargestStandardId);
    frame.size = static_cast<std::uint8_t>(random() % 9);
    for (std::size_t b = 0; b < frame.size; ++b) frame.data[b] = static_cast<std::uint8_t>(random());
    EXPECT_EQ(from_kernel(to_kernel(frame)), frame);
  }
}

TEST(KernelFrame, WhatIsNoDataFrameIsNone) {
  can_frame remote{};
  remote.can_id = 0x111 | CAN_RTR_FLAG;
  EXPECT_FALSE(from_kernel(remote));
  can_frame longer{};
  longer.can_dlc = 9;
  EXPECT_FALSE(from_kernel(longer));
  EXPECT_FALSE(from_kernel(make_error_frame(PortState::kBusOff)));
}

TEST(KernelFrame, ErrorFramesSayTheStateAndARestartIsCounted) {
  PortCounters counters;
  PortState state = PortState::kActive;
  const auto take = [&](const can_frame& frame) { return state = take_error_frame(frame, state, counters); };
  EXPECT_EQ(take(make_error_frame(PortState::kPassive)), PortState::kPassive);
  can_frame no_acknowledge{};
  no_acknowledge.can_id = CAN_ERR_FLAG | CAN_ERR_ACK;
  EXPECT_EQ(take(no_acknowledge), PortState::kPassive) << "says nothing of the state";
  EXPECT_EQ(take(make_error_frame(PortState::kBusOff)), PortState::kBusOff);
  can_frame active{};
  active.can_id = CAN_ERR_FLAG | CAN_ERR_CRTL;
  active.data[1] = CAN_ERR_CRTL_ACTIVE;
  EXPECT_EQ(take(active), PortState::kBusOff) << "only a restart ends bus-off";
  EXPECT_EQ(take(make_error_frame(PortState::kActive)), PortState::kActive);
  EXPECT_EQ(counters.restarts, 1);
  EXPECT_EQ(counters.error_frames, 5);
}

}  // namespace
}  // namespace arpent::can
