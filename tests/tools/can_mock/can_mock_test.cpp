// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The mock behind real local ports, driven by the real drivers, on a clock of the test's own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "common/error.h"
#include "common/net/private_network.h"
#include "drivers/base/agilex_driver.h"
#include "drivers/base/wifibot_driver.h"
#include "drivers/can/local_hub.h"
#include "tools/can_mock/mock.h"

namespace arpent::tools {
namespace {

using base::GateState;
using testing::Contains;
using testing::HasSubstr;

class CanMockTest : public testing::Test {
 protected:
  CanMockTest() {
    options_.motors.geometry.track_m = options_.base.geometry.track_m = 0.39;
    std::filesystem::remove(path_);
  }

  void start(const std::string& protocol, const std::string& listen) {
    options_.base.protocol = protocol;
    options_.listen = listen;
    mock_ = make_mock(options_, clock_);
  }
  void run(base::BaseDriver& driver, int cycles, std::optional<Twist2> command = std::nullopt) {
    for (int i = 0; i < cycles; ++i) {
      now_ += base::kCycle;
      if (command) (void)driver.gate().offer(*command, now_);
      for (auto& fault : driver.step(now_)) faults_.push_back(fault);
      mock_->wait(Duration(0));
      mock_->step(now_, to_seconds(base::kCycle));
    }
  }
  /// Arms, drives and stops.
  void drive(base::BaseDriver& driver) {
    run(driver, 30);
    ASSERT_TRUE(driver.status().heard);
    ASSERT_FALSE(driver.gate().arm());
    run(driver, 10, Twist2{});
    run(driver, 100, Twist2{0.3, 0.4});
    EXPECT_NEAR(mock_->motors().ground_twist().speed_mps, 0.3, 5e-3);
    EXPECT_NEAR(mock_->motors().ground_twist().turn_rate_radps, 0.4, 0.02);
    EXPECT_NEAR(0.5 * (driver.status().left_m + driver.status().right_m), 0.57, 0.04);
    run(driver, 50);
    EXPECT_LT(std::abs(mock_->motors().ground_twist().speed_mps), 5e-3);
    EXPECT_TRUE(faults_.empty()) << faults_.front();
  }

  std::string path_ = testing::TempDir() + "/mock_" + std::to_string(getpid());
  Time now_ = from_utime(1'000'000);
  Now clock_ = [this] { return now_; };
  MockOptions options_;
  std::unique_ptr<Mock> mock_;
  std::vector<std::string> faults_;
  base::DriverParams params_{.geometry = {.track_m = 0.39}};
};

TEST_F(CanMockTest, AnAgilexChassisOnASocketIsDriven) {
  start("agilex_v2", "socket:" + path_);
  can::LocalPort port(path_, clock_);
  base::AgilexDriver driver(params_, port);
  drive(driver);
  EXPECT_THAT(mock_->condition(), HasSubstr("mode CAN, 1 clients"));
}

TEST_F(CanMockTest, EventsTroubleTheChassisAndTheDriverTells) {
  start("agilex_v2", "socket:" + path_);
  can::LocalPort port(path_, clock_);
  base::AgilexDriver driver(params_, port);
  drive(driver);
  EXPECT_TRUE(mock_->apply("battery 21.5"));
  EXPECT_TRUE(mock_->apply("remote on 0.2 0"));
  run(driver, 50);
  EXPECT_THAT(faults_, Contains(HasSubstr("battery is empty")));
  EXPECT_THAT(faults_, Contains(HasSubstr("remote control has the base")));
  EXPECT_TRUE(mock_->apply("battery 25"));
  run(driver, 50);
  EXPECT_NEAR(driver.status().twist.speed_mps, 0.2, 1e-3) << "the sticks drive it";
  EXPECT_TRUE(mock_->apply("remote off"));
  EXPECT_TRUE(mock_->apply("button on"));
  run(driver, 20);
  EXPECT_EQ(driver.gate().state(), GateState::kStopped);
  EXPECT_TRUE(mock_->apply("bus off"));
  run(driver, 5);
  EXPECT_THAT(faults_, Contains(HasSubstr("bus-off")));
  EXPECT_TRUE(mock_->apply("bus active"));
  EXPECT_TRUE(mock_->apply("count left 2147483600"));
  EXPECT_TRUE(mock_->apply("slip 0.2 0"));
  EXPECT_TRUE(mock_->apply("encoder right stuck"));
  EXPECT_TRUE(mock_->apply("block on"));
  EXPECT_TRUE(mock_->apply("loss 0.5"));
  EXPECT_TRUE(mock_->apply("restart"));
}

TEST_F(CanMockTest, EventsThatMakeNoSenseAreNotUnderstood) {
  start("agilex_v2", "socket:" + path_);
  for (const char* event :
       {"", "dance", "slip 0.1", "slip 2 0", "slip a 0", "encoder up stuck", "encoder left lazy", "count left 1e12",
        "battery", "battery nan", "bus sideways", "loss 2", "remote on", "block"}) {
    EXPECT_FALSE(mock_->apply(event)) << event;
  }
}

TEST_F(CanMockTest, AWifibotOnASerialLineIsDriven) {
  start("wifibot", "serial:" + path_);
  const auto port = base::open_byte_port("serial:" + path_, clock_);
  base::WifibotDriver driver(params_, options_.base.wifibot, *port);
  drive(driver);
  EXPECT_EQ(mock_->condition(), "classic framing");
  EXPECT_FALSE(mock_->apply("button on")) << "it has none";
}

TEST_F(CanMockTest, AWifibotOverTcpAndUdpIsDriven) {
  const std::string not_private = enter_private_network();
  if (!not_private.empty()) GTEST_SKIP() << not_private;
  for (const std::string kind : {"tcp", "udp"}) {
    start("wifibot", kind + ":15020");
    const auto port = base::open_byte_port(kind + ":127.0.0.1:15020", clock_);
    base::WifibotDriver driver(params_, options_.base.wifibot, *port);
    faults_.clear();
    drive(driver);
    mock_.reset();
  }
}

TEST_F(CanMockTest, AnImpossiblePlaceToListenIsRefused) {
  for (const char* listen : {"", "tcp:15020", "socket:", "a b"}) EXPECT_THROW(start("agilex_v2", listen), InputError);
  for (const char* listen : {"", "can0", "tcp:", "tcp:0", "udp:70000", "serial:"}) {
    EXPECT_THROW(start("wifibot", listen), InputError) << listen;
  }
}

}  // namespace
}  // namespace arpent::tools
