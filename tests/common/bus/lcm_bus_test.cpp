// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The live bus over real UDP multicast, in a network namespace of its own where that is permitted, otherwise on
// loopback with a port of its own.
#include "common/bus/lcm_bus.h"

#include <gtest/gtest.h>

#include <chrono>
#include <numeric>
#include <thread>

#include "common/error.h"
#include "common/net/private_network.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;

std::string url() {
  static const std::string reason = enter_private_network();
  return "udpm://239.255.76.67:" + std::to_string(private_port()) + "?ttl=0&recv_buf_size=4194304";
}

Bytes ramp(std::size_t size) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

/// Runs `bus` until `done` or 5 s have passed.
template <class Done>
void run(LcmBus& bus, Done done) {
  const auto limit = std::chrono::steady_clock::now() + 5s;
  while (!done() && std::chrono::steady_clock::now() < limit) bus.run_for(20ms);
}

TEST(LcmBus, ALargeMessageArrivesWhole) {
  LcmBus sender(url());
  LcmBus receiver(url());
  const Bytes sent = ramp(700000);
  Bytes received;
  receiver.subscribe_bytes("BIG", {}, [&](BytesView view) { received.assign(view.begin(), view.end()); });
  receiver.start();
  sender.publish_bytes("BIG", sent);
  run(receiver, [&] { return !received.empty(); });
  EXPECT_EQ(received, sent);
  EXPECT_EQ(receiver.health().counter("BIG", "received"), 1);
  EXPECT_EQ(sender.health().counter("BIG", "published"), 1);
}

TEST(LcmBus, ASlowHandlerLosesTheOldestAndEachLossIsCounted) {
  LcmBus sender(url());
  LcmBus receiver(url());
  std::vector<std::uint8_t> seen;
  receiver.subscribe_bytes("C", {1, 1000, Duration(0)}, [&](BytesView view) {
    seen.push_back(view[0]);
    if (seen.size() == 1) std::this_thread::sleep_for(300ms);
  });
  receiver.start();
  sender.publish_bytes("C", Bytes{0});
  std::thread burst([&] {
    std::this_thread::sleep_for(100ms);
    for (std::uint8_t i = 1; i <= 10; ++i) sender.publish_bytes("C", Bytes{i});
  });
  run(receiver, [&] { return !seen.empty() && seen.back() == 10; });
  burst.join();
  EXPECT_EQ(seen, (std::vector<std::uint8_t>{0, 10}));
  EXPECT_EQ(receiver.health().counter("C", "received"), 11);
  EXPECT_EQ(receiver.health().counter("C", "dropped"), 9);
}

TEST(LcmBus, TimersRingWhileNothingArrives) {
  LcmBus bus(url());
  int rings = 0;
  bus.every(10ms, [&] { ++rings; });
  bus.start();
  run(bus, [&] { return rings >= 3; });
  EXPECT_GE(rings, 3);
}

TEST(LcmBus, AnImpossibleAddressIsOneClearError) {
  EXPECT_THROW(LcmBus("nonsense://"), InputError);
}

}  // namespace
}  // namespace arpent
