// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/control/live_base.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <arpent/estop_t.hpp>
#include <atomic>
#include <chrono>
#include <random>
#include <thread>

#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/net/private_network.h"
#include "common/process/real_time.h"
#include "drivers/base/agilex_chassis.h"
#include "drivers/base/wire.h"
#include "drivers/can/local_hub.h"

namespace arpent::bench {
namespace {

constexpr int kStops = 200;
constexpr int kBusyLoops = 4;
constexpr Twist2 kDriving{0.3, 0};

Time steady_now() {
  return Time(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

/// The hub's own place; it notes when the newest motion command came.
class WatchedHub : public can::CanPort {
 public:
  explicit WatchedHub(const std::string& path) : hub_(path, steady_now) {}
  bool send(const can::CanFrame& frame) override { return hub_.send(frame); }
  std::optional<can::LoggedFrame> receive() override {
    auto frame = hub_.receive();
    const auto motion = frame ? base::agilex::decode_motion(frame->frame) : std::nullopt;
    if (motion) {
      moving = *motion != Twist2{};
      heard_at = steady_now();
    }
    return frame;
  }
  can::PortState state() const override { return hub_.state(); }
  can::PortCounters counters() const override { return hub_.counters(); }
  void wait(Duration longest) { hub_.wait(longest); }

  bool moving = false;
  Time heard_at{};

 private:
  can::LocalHub hub_;
};

class LiveBase {
 public:
  LiveBase() : path_(fmt::format("/tmp/arpent_bench_can_{}", getpid())), hub_(path_), chassis_({}, hub_), bus_(url_) {
    const std::string robot = std::string("robot=") + ARPENT_SOURCE_DIR + "/config/robots/wifibot.yaml";
    const std::string port = "port=socket:" + path_;
    driver_ = fork();
    if (driver_ == 0) {
      // 200 presses of the emergency stop are no news.
      dup2(open("/dev/null", O_WRONLY), STDERR_FILENO);
      execl(ARPENT_BIN_DIR "/base_driver_process", "base_driver_process", "--set", robot.c_str(), "--set", port.c_str(),
            "--lcm-url", url_.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
    run(Duration(1'000'000), [] { return false; });
  }
  ~LiveBase() {
    kill(driver_, SIGTERM);
    waitpid(driver_, nullptr, 0);
  }
  LiveBase(const LiveBase&) = delete;
  LiveBase& operator=(const LiveBase&) = delete;

  /// The chassis lives on until `done`, or for `longest`; whether it is done.
  bool run(Duration longest, const std::function<bool()>& done) {
    for (const Time end = steady_now() + longest; steady_now() < end;) {
      hub_.wait(Duration(1000));
      const Time now = steady_now();
      chassis_.step(now, to_seconds(now - std::exchange(stepped_, now)));
      if (done()) return true;
    }
    return done();
  }
  void command(const Twist2& twist) { publish(bus_, channels::kWheelCommand, base::to_wire({steady_now(), twist})); }
  void request(base::Action action) {
    publish(bus_, channels::kBaseRequest, base::to_wire({steady_now(), action, "bench"}));
  }
  void stop() {
    estop_t message{};
    message.source = "bench";
    publish(bus_, channels::kEstop, message);
  }

  /// From whatever state to driving; commands go on every 50 ms for `duration`. The time of the last one.
  Time drive(Duration duration) {
    command({});
    request(base::Action::kRelease);
    request(base::Action::kArm);
    run(Duration(30'000), [] { return false; });
    Time last = steady_now();
    for (const Time end = last + duration; last < end;) {
      last = steady_now();
      command(kDriving);
      run(std::min(Duration(50'000), end - last), [] { return false; });
    }
    if (!hub_.moving) throw InputError("bench control: the base_driver_process does not drive");
    return last;
  }
  /// How long from `since` until a zero command is on the bus [ms].
  double ms_to_zero(Time since) {
    if (!run(Duration(2'000'000), [this] { return !hub_.moving; })) return 2000;
    return 1e3 * to_seconds(hub_.heard_at - since);
  }
  [[nodiscard]] bool real_time() const { return sched_getscheduler(driver_) == SCHED_FIFO; }

 private:
  std::string url_ = fmt::format("udpm://239.255.76.67:{}?ttl=0", private_port());
  std::string path_;
  WatchedHub hub_;
  base::AgilexChassis chassis_;
  LcmBus bus_;
  Time stepped_ = steady_now();
  pid_t driver_ = -1;
};

double p99(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[(values.size() - 1) * 99 / 100];
}

void time_dead_man(Report& report, LiveBase& live) {
  std::mt19937 random(1);
  std::vector<double> ms;
  for (int i = 0; i < kStops; ++i) {
    const Time last = live.drive(Duration(60'000 + static_cast<std::int64_t>(random() % 50'000)));
    ms.push_back(live.ms_to_zero(last));
  }
  report.add("deadman.p99_ms", p99(ms), "ms", "bar <= 220; 200 stops of the live process");
  report.add("deadman.max_ms", *std::max_element(ms.begin(), ms.end()), "ms");
}

void time_emergency_stop(Report& report, LiveBase& live, const std::optional<std::string>& refused) {
  if (refused || !live.real_time()) {
    fmt::print("estop.p99_ms: skipped: {}\n", refused.value_or("the driver may not run under SCHED_FIFO"));
    return;
  }
  std::atomic<bool> done{false};
  std::vector<std::jthread> busy;
  for (int i = 0; i < kBusyLoops; ++i) {
    busy.emplace_back([&done] {
      const sched_param ordinary{};
      sched_setscheduler(0, SCHED_OTHER, &ordinary);
      while (!done) {
      }
    });
  }
  std::mt19937 random(2);
  std::vector<double> ms;
  for (int i = 0; i < kStops; ++i) {
    live.drive(Duration(60'000 + static_cast<std::int64_t>(random() % 20'000)));
    const Time pressed = steady_now();
    live.stop();
    ms.push_back(live.ms_to_zero(pressed));
  }
  done = true;
  report.add("estop.p99_ms", p99(ms), "ms", "bar <= 5; 200 presses with 4 busy loops");
  report.add("estop.max_ms", *std::max_element(ms.begin(), ms.end()), "ms");
}

}  // namespace

void time_live_base(Report& report) {
  (void)enter_private_network();
  LiveBase live;
  // After the driver was started: it shall find its schedule by itself.
  const auto refused = enter_real_time();
  time_dead_man(report, live);
  time_emergency_stop(report, live, refused);
  const sched_param ordinary{};
  sched_setscheduler(0, SCHED_OTHER, &ordinary);
}

}  // namespace arpent::bench
