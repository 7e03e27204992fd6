// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The base_driver_process executable in front of a stand-in chassis, stopped and continued as a whole: commands that
// waited in its socket meanwhile move nothing, though they reach it only now.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <functional>

#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/net/private_network.h"
#include "drivers/base/agilex_chassis.h"
#include "drivers/base/wire.h"
#include "drivers/can/local_hub.h"

namespace arpent {
namespace {

using namespace std::chrono_literals;

constexpr Twist2 kForward{0.3, 0};

Time steady_now() {
  return Time(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

class SleepingDriver : public testing::Test {
 protected:
  void SetUp() override {
    (void)enter_private_network();
    try {
      bus_ = std::make_unique<LcmBus>(url_);
    } catch (const InputError& error) {
      GTEST_SKIP() << "no multicast here: " << error.what();
    }
    subscribe<wheel_state_t>(*bus_, channels::kWheelState, {}, [this](const wheel_state_t& message) {
      if (const auto state = base::from_wire(message)) state_ = *state;
    });
    bus_->start();
    driver_ = fork();
    if (driver_ == 0) exec_driver();
  }
  ~SleepingDriver() override {
    if (driver_ <= 0) return;
    kill(driver_, SIGCONT);
    kill(driver_, SIGTERM);
    waitpid(driver_, nullptr, 0);
  }
  [[noreturn]] void exec_driver() const {
    dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
    const std::string robot = std::string("robot=") + ARPENT_SOURCE_DIR + "/config/robots/wifibot.yaml";
    const std::string port = "port=socket:" + path_;
    execl(ARPENT_BIN_DIR "/base_driver_process", "base_driver_process", "--set", robot.c_str(), "--set", port.c_str(),
          "--lcm-url", url_.c_str(), "--run-for-s", "60", static_cast<char*>(nullptr));
    _exit(127);
  }

  /// Chassis and bus live on until `done`, at most for `longest`; commands go out every 50 ms if there is one. The
  /// fastest that the chassis was told to go meanwhile is in told_mps_.
  bool run(Duration longest, const std::optional<Twist2>& command, const std::function<bool()>& done) {
    told_mps_ = 0;
    Time next_command{};
    for (const Time end = steady_now() + longest; steady_now() < end;) {
      const Time now = steady_now();
      if (command && now >= next_command) {
        publish(*bus_, channels::kWheelCommand, base::to_wire({now, *command}));
        next_command = now + 50ms;
      }
      hub_.wait(Duration(1000));
      chassis_.step(now, to_seconds(now - std::exchange(stepped_, now)));
      bus_->run_for(Duration(0));
      if (state_) told_mps_ = std::max(told_mps_, state_->status.commanded.speed_mps);
      if (done()) return true;
    }
    return done();
  }
  void run(Duration duration, const std::optional<Twist2>& command) {
    (void)run(duration, command, [] { return false; });
  }
  double speed_mps() const { return chassis_.twist().speed_mps; }
  bool is(base::GateState gate) const { return state_ && state_->status.heard && state_->gate == gate; }

  std::string url_ = fmt::format("udpm://239.255.76.67:{}?ttl=0", private_port());
  std::string path_ = fmt::format("{}sleeping_driver_{}", testing::TempDir(), getpid());
  can::LocalHub hub_{path_, steady_now};
  base::AgilexChassis chassis_{{}, hub_};
  Time stepped_ = steady_now();
  std::unique_ptr<LcmBus> bus_;
  std::optional<base::WheelState> state_;
  double told_mps_ = 0;
  pid_t driver_ = -1;
};

TEST_F(SleepingDriver, CommandsThatWaitedWhileItSleptDoNotMoveTheWheels) {
  ASSERT_TRUE(run(10s, std::nullopt, [this] { return is(base::GateState::kDisarmed); })) << "it does not come up";
  publish(*bus_, channels::kBaseRequest, base::to_wire({steady_now(), base::Action::kArm, "test"}));
  ASSERT_TRUE(run(5s, Twist2{}, [this] { return is(base::GateState::kArmed); }));
  ASSERT_TRUE(run(5s, kForward, [this] { return speed_mps() > 0.25; }));

  kill(driver_, SIGSTOP);
  run(400ms, kForward);  // eight commands wait in its socket; then the commander is gone
  ASSERT_TRUE(run(5s, std::nullopt, [this] { return speed_mps() < 0.01; })) << "the chassis has a dead man of its own";
  kill(driver_, SIGCONT);
  const std::int64_t asleep = state_->sequence;
  const std::int64_t half_a_second = 25;
  double fastest_mps = 0;
  ASSERT_TRUE(run(10s, std::nullopt, [&] {
    fastest_mps = std::max(fastest_mps, speed_mps());
    return state_->sequence > asleep + half_a_second;
  })) << "it does not go on";
  EXPECT_LT(fastest_mps, 0.01);
  EXPECT_EQ(state_->status.commanded, Twist2{});

  // The port was lost or the base silent for it: what it did about that is its own affair. Fresh orders move it again.
  publish(*bus_, channels::kBaseRequest, base::to_wire({steady_now(), base::Action::kRelease, "test"}));
  publish(*bus_, channels::kBaseRequest, base::to_wire({steady_now(), base::Action::kArm, "test"}));
  ASSERT_TRUE(run(5s, Twist2{}, [this] { return is(base::GateState::kArmed); }));
  EXPECT_TRUE(run(5s, kForward, [this] { return speed_mps() > 0.25; }));
}

}  // namespace
}  // namespace arpent
