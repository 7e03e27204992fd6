// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_frame.h"

#include <gtest/gtest.h>

#include <random>

namespace arpent::can {
namespace {

TEST(CanFrame, ReadsCandumpsOwnExample) {
  const auto logged = from_candump_line("(1436509053.850870) can0 111#0096000000000000");
  ASSERT_TRUE(logged);
  EXPECT_EQ(to_utime(logged->stamp), 1436509053850870);
  EXPECT_EQ(logged->interface, "can0");
  EXPECT_EQ(logged->frame.id, 0x111U);
  EXPECT_EQ(logged->frame.size, 8);
  EXPECT_EQ(logged->frame.data[1], 0x96);
  EXPECT_EQ(to_candump_line(*logged), "(1436509053.850870) can0 111#0096000000000000");
}

TEST(CanFrame, TextComesBackWhatItWas) {
  std::mt19937 random(1);
  for (int i = 0; i < 500; ++i) {
    CanFrame frame;
    frame.extended = random() % 2 == 0;
    frame.id = static_cast<std::uint32_t>(random() & (frame.extended ? 0x1FFFFFFFU : 0x7FFU));
    frame.size = static_cast<std::uint8_t>(random() % 9);
    for (std::size_t k = 0; k < frame.size; ++k) frame.data[k] = static_cast<std::uint8_t>(random());
    EXPECT_EQ(from_text(to_text(frame)), frame);
    const LoggedFrame logged{from_utime(static_cast<std::int64_t>(random())), "vcan1", frame};
    EXPECT_EQ(from_candump_line(to_candump_line(logged))->frame, frame);
    EXPECT_EQ(from_candump_line(to_candump_line(logged))->stamp, logged.stamp);
  }
}

TEST(CanFrame, WhatIsNoFrameIsNotRead) {
  for (const char* text : {"", "#", "111", "11#00", "111#0", "111#001122334455667788", "800#00", "111#R", "111##100",
                           "111#0G", "20000000#00", "+11#00", "111#-1"}) {
    EXPECT_FALSE(from_text(text)) << text;
  }
  for (const char* line :
       {"", "(1.5) can0 111#00", "1436509053.850870 can0 111#00", "(1436509053.850870) can0", "(x.850870) can0 111#00",
        "(99999999999999999.850870) can0 111#00", "(-1.000000) can0 111#00"}) {
    EXPECT_FALSE(from_candump_line(line)) << line;
  }
}

}  // namespace
}  // namespace arpent::can
