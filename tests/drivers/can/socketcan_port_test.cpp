// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The port on a virtual CAN interface of Linux. Where the kernel has no CAN these tests skip and say so; vcan_uml.sh
// runs them in user-mode Linux.
#include "drivers/can/socketcan_port.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "drivers/can/kernel_frame.h"

namespace arpent::can {
namespace {

using testing::HasSubstr;

Time real_now() {
  return Time(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

bool shell(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

constexpr char kInterface[] = "arpentcan0";

class SocketCanTest : public testing::Test {
 protected:
  void SetUp() override {
    const FileDescriptor probe(socket(PF_CAN, SOCK_RAW, 1));
    if (!probe) GTEST_SKIP() << "this kernel opens no CAN sockets; tests/drivers/can/vcan_uml.sh runs these tests";
    if (!make()) GTEST_SKIP() << "no vcan interface can be made here (ip link add type vcan)";
  }
  void TearDown() override { remove(); }
  static bool make() {
    return shell(std::string("ip link add dev ") + kInterface + " type vcan && ip link set " + kInterface + " up");
  }
  static void remove() { shell(std::string("ip link del ") + kInterface); }

  /// What arrives within 200 ms.
  static std::optional<LoggedFrame> wait(CanPort& port) {
    for (int i = 0; i < 200; ++i) {
      if (auto frame = port.receive()) return frame;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::nullopt;
  }
  /// Sends a frame of the kernel's kind, error frames too, as the controller's driver would.
  static void inject(const can_frame& frame) {
    const FileDescriptor fd(socket(PF_CAN, SOCK_RAW, 1));
    ifreq request{};
    std::copy(std::begin(kInterface), std::end(kInterface), request.ifr_name);
    ASSERT_EQ(ioctl(fd.get(), SIOCGIFINDEX, &request), 0);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = request.ifr_ifindex;
    ASSERT_EQ(bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    ASSERT_EQ(write(fd.get(), &frame, sizeof(frame)), static_cast<ssize_t>(sizeof(frame)));
  }

  Now clock_ = real_now;
};

TEST_F(SocketCanTest, FramesPassBothWaysWithTheKernelsTime) {
  SocketCanPort a(kInterface, {}, clock_), b(kInterface, {}, clock_);
  const Time before = real_now();
  ASSERT_TRUE(a.send(*from_text("111#0096000000000000")));
  const Time after = real_now();
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  const auto heard = wait(b);
  ASSERT_TRUE(heard);
  EXPECT_EQ(to_text(heard->frame), "111#0096000000000000");
  EXPECT_GE(heard->stamp, before - Duration(2000));
  EXPECT_LE(heard->stamp, after + Duration(5000)) << "of its arrival, not of its reading 30 ms later";
  ASSERT_TRUE(b.send(*from_text("00000117#0000C738")));
  EXPECT_TRUE(wait(a)->frame.extended);
  EXPECT_FALSE(a.receive()) << "own frames are not heard";
}

TEST_F(SocketCanTest, FiltersLetOnlyStandardFramesOfTheirIdentifiersThrough) {
  SocketCanPort all(kInterface, {}, clock_), some(kInterface, {0x211}, clock_);
  for (const char* text : {"210#00", "00000211#00", "12345211#00", "211#01"}) ASSERT_TRUE(all.send(*from_text(text)));
  EXPECT_EQ(to_text(wait(some)->frame), "211#01");
  EXPECT_FALSE(some.receive());
}

TEST_F(SocketCanTest, BusOffIsSeenAndItsEndIsCounted) {
  SocketCanPort port(kInterface, {0x211}, clock_);
  inject(make_error_frame(PortState::kBusOff));
  EXPECT_FALSE(wait(port));
  EXPECT_EQ(port.state(), PortState::kBusOff);
  EXPECT_FALSE(port.send(*from_text("111#00")));
  inject(make_error_frame(PortState::kActive));
  EXPECT_FALSE(wait(port));
  EXPECT_EQ(port.state(), PortState::kActive);
  EXPECT_EQ(port.counters().restarts, 1);
  inject(make_error_frame(PortState::kBusOff));
  inject(to_kernel(*from_text("211#00")));
  EXPECT_TRUE(wait(port));
  EXPECT_EQ(port.state(), PortState::kActive) << "traffic says so too";
  EXPECT_EQ(port.counters().restarts, 2);
}

TEST_F(SocketCanTest, AnInterfaceThatVanishesIsOpenedAgain) {
  SocketCanPort port(kInterface, {}, clock_);
  ASSERT_EQ(port.state(), PortState::kActive);
  remove();
  EXPECT_FALSE(wait(port));
  EXPECT_EQ(port.state(), PortState::kGone);
  EXPECT_NE(port.fault(), "");
  EXPECT_FALSE(port.send(*from_text("111#00")));
  ASSERT_TRUE(make());
  EXPECT_FALSE(wait(port));
  EXPECT_FALSE(wait(port));
  EXPECT_EQ(port.state(), PortState::kActive);
  EXPECT_EQ(port.counters().restarts, 1);
  SocketCanPort other(kInterface, {}, clock_);
  ASSERT_TRUE(other.send(*from_text("111#00")));
  EXPECT_TRUE(wait(port));
}

TEST_F(SocketCanTest, AnInterfaceThatIsSetDownIsOpenedAgainWhenItIsUp) {
  SocketCanPort port(kInterface, {}, clock_);
  ASSERT_TRUE(shell(std::string("ip link set down ") + kInterface));
  EXPECT_FALSE(wait(port));
  EXPECT_EQ(port.state(), PortState::kGone);
  EXPECT_FALSE(wait(port));
  EXPECT_THAT(port.fault(), HasSubstr("is down"));
  ASSERT_TRUE(shell(std::string("ip link set up ") + kInterface));
  EXPECT_FALSE(wait(port));
  EXPECT_FALSE(wait(port));
  EXPECT_EQ(port.state(), PortState::kActive);
}

TEST(SocketCan, AnInterfaceThatIsNotThereIsSaidAndLookedForAgain) {
  SocketCanPort port("nocan7", {}, real_now);
  EXPECT_EQ(port.state(), PortState::kGone);
  EXPECT_NE(port.fault(), "");
  EXPECT_FALSE(port.send(*from_text("111#00")));
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.counters().refused, 1);
}

}  // namespace
}  // namespace arpent::can
