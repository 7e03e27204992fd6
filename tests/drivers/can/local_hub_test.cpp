// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Hub and clients of the local socket, on a clock of the test's own.
#include "drivers/can/local_hub.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "common/error.h"

namespace arpent::can {
namespace {

class LocalHubTest : public testing::Test {
 protected:
  std::string path_ = testing::TempDir() + "/hub_" + std::to_string(getpid()) + "_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name();
  Time now_ = from_utime(1'000'000);
  Now clock_ = [this] { return now_; };
  CanFrame frame_ = *from_text("111#0096000000000000");

  std::unique_ptr<LocalHub> hub() { return std::make_unique<LocalHub>(path_, clock_); }
};

TEST_F(LocalHubTest, EveryPlaceHearsTheOthersAndNotItself) {
  const auto hub = this->hub();
  LocalPort a(path_, clock_), b(path_, clock_);
  hub->wait(Duration(0));
  EXPECT_EQ(hub->clients(), 2);
  ASSERT_TRUE(a.send(frame_));
  EXPECT_EQ(hub->receive()->frame, frame_);
  EXPECT_EQ(b.receive()->frame, frame_);
  EXPECT_FALSE(a.receive());
  ASSERT_TRUE(hub->send(*from_text("00000117#0000C738")));
  EXPECT_TRUE(a.receive()->frame.extended);
  EXPECT_TRUE(b.receive());
  EXPECT_FALSE(hub->receive());
}

TEST_F(LocalHubTest, AHubThatIsNotThereIsLookedForEveryFifthOfASecond) {
  LocalPort port(path_, clock_);
  EXPECT_EQ(port.state(), PortState::kGone);
  EXPECT_NE(port.fault(), "");
  EXPECT_FALSE(port.send(frame_));
  EXPECT_EQ(port.counters().refused, 1);
  auto hub = this->hub();
  now_ += Duration(199'000);
  EXPECT_FALSE(port.send(frame_));
  now_ += Duration(1'000);
  EXPECT_TRUE(port.send(frame_));
  EXPECT_EQ(port.state(), PortState::kActive);
  EXPECT_EQ(port.counters().restarts, 0) << "it was never there before";
  hub.reset();
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.state(), PortState::kGone);
  hub = this->hub();
  now_ += Duration(200'000);
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.state(), PortState::kActive);
  EXPECT_EQ(port.counters().restarts, 1);
}

TEST_F(LocalHubTest, BusOffReachesTheClientAndSoDoesItsEnd) {
  const auto hub = this->hub();
  LocalPort port(path_, clock_);
  hub->wait(Duration(0));
  hub->set_client_state(PortState::kPassive);
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.state(), PortState::kPassive);
  EXPECT_TRUE(port.send(frame_)) << "passive still takes part";
  EXPECT_TRUE(hub->receive());
  hub->set_client_state(PortState::kBusOff);
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.state(), PortState::kBusOff);
  EXPECT_FALSE(port.send(frame_));
  hub->set_client_state(PortState::kActive);
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.state(), PortState::kActive);
  EXPECT_EQ(port.counters().restarts, 1);
}

TEST_F(LocalHubTest, AnUnpluggedClientComesBackByItself) {
  const auto hub = this->hub();
  LocalPort port(path_, clock_);
  hub->wait(Duration(0));
  hub->set_client_state(PortState::kGone);
  EXPECT_FALSE(port.receive());
  EXPECT_EQ(port.state(), PortState::kGone);
  hub->set_client_state(PortState::kActive);
  now_ += Duration(200'000);
  ASSERT_TRUE(port.send(frame_));
  EXPECT_EQ(hub->receive()->frame, frame_);
}

TEST_F(LocalHubTest, FramesAreLostAtTheRateAskedFor) {
  const auto hub = this->hub();
  LocalPort port(path_, clock_);
  hub->wait(Duration(0));
  hub->set_faults({.loss = 0.3, .delay = Duration(0)});
  int heard = 0;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(port.send(frame_));
    heard += hub->receive() ? 1 : 0;
  }
  // Binomial, 1000 at 0.7: 5 deviations are 72.
  EXPECT_NEAR(heard, 700, 72);
}

TEST_F(LocalHubTest, ASecondHubAndAnImpossiblePathAreRefused) {
  const auto hub = this->hub();
  EXPECT_THROW(LocalHub(path_, clock_), InputError);
  EXPECT_THROW(LocalPort("", clock_), InputError);
  EXPECT_THROW(LocalPort(std::string(200, 'x'), clock_), InputError);
  EXPECT_THROW(LocalHub("/no/such/folder/hub", clock_), InputError);
}

}  // namespace
}  // namespace arpent::can
