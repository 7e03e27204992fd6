// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// CAN on the robot's bus: the message's conversion, the port, and the choice of ports by text.
#include "drivers/can/process/bus_port.h"

#include <gtest/gtest.h>

#include "common/bus/lockstep.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "drivers/can/process/open_can_port.h"
#include "drivers/can/wire.h"

namespace arpent::can {
namespace {

TEST(CanWire, FramesComeBackAsTheyWere) {
  const SentFrames sent{from_utime(7), "driver", {*from_text("111#0102030405060708"), *from_text("1FFFFFFF#AB")}};
  const auto back = from_wire(to_wire(sent));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->stamp, sent.stamp);
  EXPECT_EQ(back->sender, "driver");
  EXPECT_EQ(back->frames, sent.frames);
}

TEST(CanWire, ImpossibleFramesAreRefused) {
  const can_frames_t good = to_wire({Time(), "x", {*from_text("7FF#0102")}});
  const auto refused = [&](auto damage) {
    can_frames_t bad = good;
    damage(bad.frames[0]);
    return !from_wire(bad);
  };
  EXPECT_TRUE(from_wire(good));
  EXPECT_TRUE(refused([](auto& f) { f.id = 0x800; }));
  EXPECT_TRUE(refused([](auto& f) { f.id = -1; }));
  EXPECT_TRUE(refused([](auto& f) { f.size = 9; }));
  EXPECT_TRUE(refused([](auto& f) { f.size = -1; }));
  EXPECT_TRUE(refused([](auto& f) { f.extended = 2; }));
}

TEST(BusPort, PlacesHearEachOtherInOneMessagePerFlushAndNotThemselves) {
  LockstepExecutor executor(from_utime(1'000'000));
  const auto [bus_a, clock_a] = executor.add_process("a");
  const auto [bus_b, clock_b] = executor.add_process("b");
  int messages = 0;
  executor.set_tap([&](Time, const std::string& channel, BytesView) { messages += channel == channels::kCan ? 1 : 0; });
  BusPort a("driver", bus_a, clock_a), b("chassis", bus_b, clock_b);
  clock_a.every(Duration(20'000), [&a = a] {
    (void)a.send(*from_text("421#01"));
    (void)a.send(*from_text("111#00"));
    a.flush();
  });
  executor.run_until(from_utime(1'020'000));
  EXPECT_EQ(messages, 1);
  const auto heard = b.receive();
  ASSERT_TRUE(heard);
  EXPECT_EQ(to_text(heard->frame), "421#01");
  EXPECT_EQ(heard->interface, "driver");
  EXPECT_EQ(heard->stamp, from_utime(1'020'000));
  EXPECT_TRUE(b.receive());
  EXPECT_FALSE(b.receive());
  EXPECT_FALSE(a.receive());
}

TEST(BusPort, GarbageOnTheChannelIsCountedAndDropped) {
  LockstepExecutor executor{Time()};
  const auto [bus, clock] = executor.add_process("a");
  BusPort port("driver", bus, clock);
  can_frames_t bad = to_wire({Time(), "x", {*from_text("7FF#0102")}});
  bad.frames[0].size = 100;
  executor.inject(Time(), channels::kCan, encode(bad));
  executor.inject(Time(), channels::kCan, Bytes(100, 0xFF));
  executor.run_until_idle();
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(bus.health().counter(channels::kCan, "invalid"), 1);
  EXPECT_EQ(bus.health().counter(channels::kCan, "undecodable"), 1);
}

TEST(OpenCanPort, APortThatIsNotThereIsOpenedLaterAndNonsenseIsRefused) {
  LockstepExecutor executor{Time()};
  const auto [bus, clock] = executor.add_process("a");
  for (const char* absent : {"can7", "socket:/no/such/hub"}) {
    EXPECT_EQ(open_can_port(absent, "driver", bus, clock)->state(), PortState::kGone);
  }
  for (const char* nonsense : {"", "serial:/dev/ttyS0", "candump:/no/such/file", "socket:", "an interface", "bus:x"}) {
    EXPECT_THROW((void)open_can_port(nonsense, "driver", bus, clock), InputError) << nonsense;
  }
}

}  // namespace
}  // namespace arpent::can
