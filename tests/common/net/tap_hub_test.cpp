// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// The hub of network namespaces, by plain UDP through it.
#include "common/net/tap_hub.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <future>
#include <thread>

#include "common/net/private_network.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

constexpr int kPort = 5005;
constexpr std::size_t kBytes = 500;
constexpr std::size_t kOnAir = 14 + 20 + 8 + kBytes;  // Ethernet, IPv4, UDP

sockaddr_in address(int station) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(kPort);
  inet_pton(AF_INET, ("10.77.0." + std::to_string(station + 1)).c_str(), &to.sin_addr);
  return to;
}

/// A socket in a network of its own behind the hub: made in a thread that moves there and ends.
class TapHubTest : public testing::Test {
 protected:
  void SetUp() override {
    static const std::string refused = enter_private_network();
    if (!refused.empty()) GTEST_SKIP() << refused;
    if (access("/dev/net/tun", R_OK | W_OK) != 0) GTEST_SKIP() << "/dev/net/tun is not accessible";
  }
  void TearDown() override {
    for (const int fd : sockets_) close(fd);
  }

  void open(const AirParams& air, int stations) {
    hub_ = std::make_unique<TapHub>(air, 3);
    for (int i = 0; i < stations; ++i) {
      std::thread([&] {
        const Result<int> tap = enter_radio_network("10.77.0." + std::to_string(i + 1));
        ASSERT_TRUE(tap) << tap.fault();
        hub_->attach(*tap);
        sockets_.push_back(socket(AF_INET, SOCK_DGRAM, 0));
        const sockaddr_in own = address(i);
        ASSERT_EQ(bind(sockets_.back(), reinterpret_cast<const sockaddr*>(&own), sizeof(own)), 0);
        const timeval patience{0, 300000};
        setsockopt(sockets_.back(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
      }).join();
    }
  }
  void send(int from, int to) {
    const std::vector<char> bytes(kBytes, 'x');
    const sockaddr_in target = address(to);
    ASSERT_EQ(sendto(sockets_[static_cast<std::size_t>(from)], bytes.data(), bytes.size(), 0,
                     reinterpret_cast<const sockaddr*>(&target), sizeof(target)),
              static_cast<ssize_t>(kBytes));
  }
  bool receive(int station) {
    char bytes[2000];
    return recv(sockets_[static_cast<std::size_t>(station)], bytes, sizeof(bytes), 0) == static_cast<ssize_t>(kBytes);
  }
  /// Addresses are asked for and learned.
  void greet(int from, int to) {
    send(from, to);
    ASSERT_TRUE(receive(to));
  }

  std::unique_ptr<TapHub> hub_;
  std::vector<int> sockets_;
};

TEST_F(TapHubTest, FramesTakeTheDelayAndAreCounted) {
  open({.delay_s = 0.05, .rate_mbps = 50}, 2);
  greet(0, 1);
  const TapHub::Traffic before = hub_->traffic();
  for (int i = 0; i < 5; ++i) {
    const auto start = Steady::now();
    send(0, 1);
    ASSERT_TRUE(receive(1));
    EXPECT_GE(Steady::now() - start, 50ms);
  }
  // The kernel may put a few short frames of its own (neighbour discovery) beside ours.
  const auto others = hub_->traffic().frames - before.frames - 5;
  const auto others_bytes = hub_->traffic().bytes - before.bytes - static_cast<std::int64_t>(5 * kOnAir);
  EXPECT_GE(others, 0);
  EXPECT_LE(others, 4);
  EXPECT_GE(others_bytes, 60 * others);
  EXPECT_LE(others_bytes, 120 * others);
}

TEST_F(TapHubTest, TheShareThatIsLostIsTheOneAskedFor) {
  open({.delay_s = 0.001, .rate_mbps = 1000}, 2);
  greet(0, 1);
  hub_->set_loss(0.2);
  constexpr int kSent = 2000;
  auto received = std::async(std::launch::async, [&] {
    int count = 0;
    while (receive(1)) ++count;
    return count;
  });
  for (int i = 0; i < kSent; ++i) {
    send(0, 1);
    if (i % 10 == 0) std::this_thread::sleep_for(1ms);
  }
  // Binomial: 1600 with a deviation of 17.9; five of them.
  EXPECT_NEAR(received.get(), 0.8 * kSent, 5 * std::sqrt(kSent * 0.2 * 0.8));
}

TEST_F(TapHubTest, ABurstIsSpreadToTheRateAndWhatTheQueueCannotHoldIsDropped) {
  open({.delay_s = 0.01, .rate_mbps = 1.0, .queue_s = 0.1}, 2);
  greet(0, 1);
  std::this_thread::sleep_for(20ms);
  constexpr int kSent = 100;
  const auto start = Steady::now();
  for (int i = 0; i < kSent; ++i) send(0, 1);
  int count = 0;
  auto last = start;
  for (; receive(1); ++count) last = Steady::now();
  // 0.1 s of queue at 1 Mbit/s are 12500 bytes: 23 frames of 542 bytes, and the one on the line.
  EXPECT_NEAR(count, 24, 3);
  EXPECT_EQ(hub_->traffic().dropped, kSent - count);
  EXPECT_GE(last - start, 100ms);
}

TEST_F(TapHubTest, WhoIsCutOffHearsNothingAndIsNotHeardUntilTheCutEnds) {
  open({.delay_s = 0.001}, 2);
  greet(0, 1);
  hub_->cut(1, true);
  send(0, 1);
  EXPECT_FALSE(receive(1));
  send(1, 0);
  EXPECT_FALSE(receive(0));
  hub_->cut(1, false);
  greet(1, 0);
  greet(0, 1);
}

}  // namespace
}  // namespace arpent
