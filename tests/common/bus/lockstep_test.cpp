// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/lockstep.h"

#include <gtest/gtest.h>

#include <string>

namespace arpent {
namespace {

using namespace std::chrono_literals;

Time at(int ms) {
  return Time(std::chrono::milliseconds(ms));
}
Bytes bytes(const std::string& text) {
  return {text.begin(), text.end()};
}
std::string text(BytesView view) {
  return {view.begin(), view.end()};
}

/// What became visible on the bus, as "ms CHANNEL content".
struct Record {
  std::vector<std::string> lines;
  LockstepExecutor::Tap tap() {
    return [this](Time time, const std::string& channel, BytesView content) {
      lines.push_back(std::to_string(to_utime(time) / 1000) + ' ' + channel + ' ' + text(content));
    };
  }
};

/// A process that answers each message on `in` by the same text on `out` with its name added.
void add_echo(LockstepExecutor& executor, const std::string& name, const std::string& in, const std::string& out,
              Duration latency, int capacity = 8) {
  Bus& bus = executor.add_process(name).bus;
  bus.subscribe_bytes(in, {capacity, 1000, latency},
                      [&bus, out, name](BytesView view) { bus.publish_bytes(out, bytes(text(view) + name)); });
}

TEST(Lockstep, OutputsAppearAfterTheDeclaredLatency) {
  LockstepExecutor executor(at(0));
  Record record;
  executor.set_tap(record.tap());
  add_echo(executor, "a", "X", "Y", 30ms);
  add_echo(executor, "b", "Y", "Z", 20ms);
  executor.inject(at(100), "X", bytes("m"));
  executor.run_until_idle();
  EXPECT_EQ(record.lines, (std::vector<std::string>{"100 X m", "130 Y ma", "150 Z mab"}));
}

TEST(Lockstep, ABusyProcessHandlesWhatWaitedWhenItIsDone) {
  LockstepExecutor executor(at(0));
  Record record;
  executor.set_tap(record.tap());
  add_echo(executor, "a", "X", "Y", 30ms);
  executor.inject(at(0), "X", bytes("1"));
  executor.inject(at(10), "X", bytes("2"));
  executor.run_until_idle();
  EXPECT_EQ(record.lines, (std::vector<std::string>{"0 X 1", "10 X 2", "30 Y 1a", "60 Y 2a"}));
}

TEST(Lockstep, AHandlerThatPublishesNothingTakesNoTime) {
  LockstepExecutor executor(at(0));
  Bus& bus = executor.add_process("p").bus;
  int handled = 0;
  bus.subscribe_bytes("X", {2, 1000, 100ms}, [&](BytesView) { ++handled; });
  for (int i = 0; i < 6; ++i) executor.inject(at(10 * i), "X", bytes("m"));
  executor.run_until_idle();
  EXPECT_EQ(handled, 6);
  EXPECT_EQ(bus.health().counter("X", "dropped"), 0);
}

TEST(Lockstep, AFullQueueDropsItsOldestAndCountsIt) {
  LockstepExecutor executor(at(0));
  Record record;
  executor.set_tap(record.tap());
  auto [bus, clock] = executor.add_process("slow");
  std::vector<std::string> seen;
  bus.subscribe_bytes("X", {2, 1000, 100ms}, [&seen, &bus = bus](BytesView view) {
    seen.push_back(text(view));
    bus.publish_bytes("Y", view);
  });
  for (int i = 0; i < 6; ++i) executor.inject(at(10 * i), "X", bytes(std::to_string(i)));
  executor.run_until_idle();
  EXPECT_EQ(seen, (std::vector<std::string>{"0", "4", "5"}));
  EXPECT_EQ(bus.health().counter("X", "received"), 6);
  EXPECT_EQ(bus.health().counter("X", "dropped"), 3);
}

TEST(Lockstep, TheSameInputsGiveTheSameMessagesWithAnyNumberOfThreads) {
  const auto run = [](int threads) {
    LockstepExecutor executor(at(0), threads);
    Record record;
    executor.set_tap(record.tap());
    for (int p = 0; p < 5; ++p) add_echo(executor, std::to_string(p), "X", "Y" + std::to_string(p % 2), 7ms * (p % 3));
    add_echo(executor, "join", "Y0", "Z", 0ms);
    add_echo(executor, "join2", "Y1", "Z", 1ms);
    for (int i = 0; i < 50; ++i) executor.inject(at(5 * i), "X", bytes(std::to_string(i)));
    executor.run_until_idle();
    return record.lines;
  };
  const auto once = run(1);
  EXPECT_GT(once.size(), 200U);
  EXPECT_EQ(once, run(1));
  EXPECT_EQ(once, run(2));
  EXPECT_EQ(once, run(4));
}

TEST(Lockstep, TimersAreEventsAtTheirSimulatedTimes) {
  LockstepExecutor executor(at(0));
  auto [bus, clock] = executor.add_process("p");
  std::vector<std::int64_t> rings;
  clock.every(20ms, [&rings, &clock = clock] { rings.push_back(to_utime(clock.now()) / 1000); });
  executor.run_until(at(65));
  EXPECT_EQ(rings, (std::vector<std::int64_t>{20, 40, 60}));
  EXPECT_EQ(executor.now(), at(65));
}

TEST(Lockstep, TimersAloneDoNotKeepItRunning) {
  LockstepExecutor executor(at(0));
  executor.add_process("p").clock.every(20ms, [] {});
  executor.run_until_idle();
  EXPECT_EQ(executor.now(), at(0));
}

TEST(Lockstep, AMessageAboveTheSizeLimitIsRefusedUnseen) {
  LockstepExecutor executor(at(0));
  Bus& bus = executor.add_process("p").bus;
  int handled = 0;
  bus.subscribe_bytes("X", {8, 4, 0ms}, [&](BytesView) { ++handled; });
  executor.inject(at(0), "X", bytes("1234"));
  executor.inject(at(0), "X", bytes("12345"));
  executor.run_until_idle();
  EXPECT_EQ(handled, 1);
  EXPECT_EQ(bus.health().counter("X", "undecodable"), 1);
}

/// Two robots with the same processes; each hears its own kind only.
TEST(LockstepRobots, ChannelsOfAPrefixAreThoseOfOneRobotAndANameWithASlashIsMeantAsItStands) {
  LockstepExecutor executor(at(0));
  Record record;
  executor.set_tap(record.tap());
  for (const std::string prefix : {"R1/", "R2/"}) {
    Bus& bus = executor.add_process("echo", prefix).bus;
    bus.subscribe_bytes("IN", {}, [&bus](BytesView view) {
      bus.publish_bytes("OUT", view);
      bus.publish_bytes("R9/OUT", view);
    });
  }
  executor.inject(at(1), "R2/IN", bytes("x"));
  executor.inject(at(2), "IN", bytes("y"));
  executor.run_until(at(5));
  EXPECT_EQ(record.lines, (std::vector<std::string>{"1 R2/IN x", "1 R2/OUT x", "1 R9/OUT x", "2 IN y"}));
}

TEST(LockstepRobots, ASilencedRobotNeitherHearsNorSpeaksButForWhatIsSpared) {
  LockstepExecutor executor(at(0));
  Record record;
  executor.set_tap(record.tap());
  for (const std::string name : {"body", "mind"}) {
    const auto [bus, clock] = executor.add_process(name, "R1/");
    clock.every(10ms, [&bus = bus, name] { bus.publish_bytes("TICK", bytes(name)); });
    bus.subscribe_bytes("IN", {}, [&bus = bus, name](BytesView) { bus.publish_bytes("HEARD", bytes(name)); });
  }
  executor.run_until(at(15));
  executor.silence("R1/", "body");
  executor.inject(at(16), "R1/IN", bytes("x"));
  executor.run_until(at(25));
  EXPECT_EQ(record.lines, (std::vector<std::string>{"10 R1/TICK body", "10 R1/TICK mind", "16 R1/IN x",
                                                    "16 R1/HEARD body", "20 R1/TICK body"}));
}

}  // namespace
}  // namespace arpent
