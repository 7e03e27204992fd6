// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/memory_bus.h"

#include <gtest/gtest.h>

#include <array>

namespace arpent::can {
namespace {

CanFrame numbered(std::uint8_t n) {
  return make_frame(0x100, std::array{n});
}

TEST(MemoryBus, EveryOtherPortHearsAFrameAfterItsDelayInOrder) {
  MemoryBus bus({.delay = Duration(1000)});
  const auto a = bus.open("a"), b = bus.open("b"), c = bus.open("c");
  bus.advance(from_utime(0));
  ASSERT_TRUE(a->send(numbered(1)));
  ASSERT_TRUE(b->send(numbered(2)));
  bus.advance(from_utime(999));
  EXPECT_FALSE(c->receive());
  bus.advance(from_utime(1000));
  const auto first = c->receive(), second = c->receive();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->frame.data[0], 1);
  EXPECT_EQ(second->frame.data[0], 2);
  EXPECT_EQ(to_utime(first->stamp), 1000);
  EXPECT_EQ(a->receive()->frame.data[0], 2);
  EXPECT_FALSE(a->receive()) << "not its own";
}

TEST(MemoryBus, ABusOffOrGonePortTakesNoPartUntilItIsBack) {
  MemoryBus bus;
  const auto a = bus.open("a"), b = bus.open("b");
  for (const PortState state : {PortState::kBusOff, PortState::kGone}) {
    bus.set_state("a", state);
    EXPECT_EQ(a->state(), state);
    EXPECT_FALSE(a->send(numbered(1)));
    ASSERT_TRUE(b->send(numbered(2)));
    bus.advance(from_utime(1000000));
    EXPECT_FALSE(a->receive());
    EXPECT_FALSE(b->receive());
  }
  bus.set_state("a", PortState::kPassive);
  EXPECT_TRUE(a->send(numbered(3)));
  bus.advance(from_utime(2000000));
  EXPECT_EQ(b->receive()->frame.data[0], 3);
}

TEST(MemoryBus, LossIsSeededAndAboutWhatWasAsked) {
  const auto heard = [](std::uint64_t seed) {
    MemoryBus bus({.loss = 0.1, .seed = seed});
    const auto a = bus.open("a"), b = bus.open("b");
    std::vector<int> numbers;
    for (int i = 0; i < 2000; ++i) {
      EXPECT_TRUE(a->send(numbered(static_cast<std::uint8_t>(i))));
      bus.advance(from_utime(1000 * (i + 1)));
      while (const auto frame = b->receive()) numbers.push_back(frame->frame.data[0]);
    }
    return numbers;
  };
  EXPECT_EQ(heard(1), heard(1));
  EXPECT_NE(heard(1), heard(2));
  EXPECT_NEAR(static_cast<double>(heard(1).size()), 1800, 60);
}

}  // namespace
}  // namespace arpent::can
