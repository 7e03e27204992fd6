// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent base`: look at the motor base, arm it, stop it, release the stop. It waits for the driver's answer and says
// why if there is none.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <arpent/estop_t.hpp>
#include <arpent/health_t.hpp>
#include <csignal>
#include <cstdio>
#include <optional>

#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "drivers/base/wire.h"

namespace {

using namespace arpent;
using base::Action;
using base::GateState;

/// Longer than a health message's period: a refusal's reason comes with it.
constexpr double kPatienceS = 1.5;
volatile std::sig_atomic_t g_stop = 0;  // set by the signal handler only

const char* describe(GateState gate) {
  switch (gate) {
    case GateState::kDisarmed:
      return "disarmed";
    case GateState::kArmed:
      return "armed";
    case GateState::kStopped:
      return "STOPPED";
  }
  return "";
}

/// What the driver says, as it comes.
class Listener {
 public:
  explicit Listener(const std::string& lcm_url) : bus_(lcm_url) {
    subscribe<wheel_state_t>(bus_, channels::kWheelState, {}, [this](const wheel_state_t& message) {
      if (const auto state = base::from_wire(message)) state_ = *state;
    });
    subscribe<health_t>(bus_, channels::kHealth, {}, [this](const health_t& message) {
      if (message.process == "base_driver_process" && !message.message.empty()) complaint_ = message.message;
    });
    bus_.start();
  }

  LcmBus& bus() { return bus_; }
  const std::optional<base::WheelState>& state() const { return state_; }
  const std::string& complaint() const { return complaint_; }

  /// Until `done` or the time is over; whether it is done.
  bool listen(double seconds, const std::function<bool()>& done) {
    const Time end = bus_.now() + from_seconds(seconds);
    while (g_stop == 0 && bus_.now() < end && !done()) bus_.run_for(Duration(20000));
    return done();
  }
  bool hear() {
    return listen(kPatienceS, [this] { return state_.has_value(); });
  }

 private:
  LcmBus bus_;
  std::optional<base::WheelState> state_;
  std::string complaint_;
};

void print(const base::WheelState& state) {
  const base::BaseStatus& s = state.status;
  fmt::print("{:9} {:+.3f} m/s {:+.3f} rad/s  told {:+.3f} {:+.3f}  way {:.3f} {:.3f} m  {:.1f} V{}{}{}{}\n",
             describe(state.gate), s.twist.speed_mps, s.twist.turn_rate_radps, s.commanded.speed_mps,
             s.commanded.turn_rate_radps, s.left_m, s.right_m, s.battery_v, s.heard ? "" : "  SILENT",
             s.remote_control ? "  remote control" : "", s.emergency_button ? "  BUTTON" : "",
             state.fault.empty() ? "" : "  fault: " + state.fault);
  std::fflush(stdout);
}

int fail(const std::string& why) {
  fmt::print(stderr, "base: {}\n", why);
  return 1;
}

constexpr char kNoDriver[] = "no base_driver_process is heard on this bus";

int show(Listener& listener) {
  if (!listener.hear()) return fail(kNoDriver);
  print(*listener.state());
  return 0;
}

int monitor(Listener& listener, double for_s) {
  constexpr double kPeriodS = 0.2;
  const Time start = listener.bus().now();
  if (!listener.hear()) return fail(kNoDriver);
  while (g_stop == 0 && (for_s <= 0 || to_seconds(listener.bus().now() - start) < for_s)) {
    const std::int64_t before = listener.state()->sequence;
    listener.listen(kPeriodS, [] { return false; });
    if (listener.state()->sequence == before) return fail("base_driver_process has fallen silent");
    print(*listener.state());
  }
  return 0;
}

int ask(Listener& listener, Action action, GateState wanted) {
  if (!listener.hear()) return fail(kNoDriver);
  publish(listener.bus(), channels::kBaseRequest, base::to_wire({listener.bus().now(), action, "arpent base"}));
  if (!listener.listen(kPatienceS, [&] { return listener.state()->gate == wanted; })) {
    return fail(fmt::format("the base is {}: {}", describe(listener.state()->gate), listener.complaint()));
  }
  print(*listener.state());
  return 0;
}

/// Sent whether or not a driver is heard.
int stop(Listener& listener) {
  estop_t message{};
  message.utime = to_utime(listener.bus().now());
  message.source = "arpent base";
  message.reason = "by hand";
  publish(listener.bus(), channels::kEstop, message);
  if (!listener.hear()) return fail(std::string(kNoDriver) + "; the stop was sent all the same");
  if (!listener.listen(kPatienceS, [&] { return listener.state()->gate == GateState::kStopped; })) {
    return fail("the driver does not stop: press the button on the chassis");
  }
  print(*listener.state());
  return 0;
}

int run(const std::string& verb, const std::string& lcm_url, double for_s) {
  Listener listener(lcm_url);
  if (verb == "stop") return stop(listener);
  if (verb == "monitor") return monitor(listener, for_s);
  if (verb == "arm") return ask(listener, Action::kArm, GateState::kArmed);
  if (verb == "disarm") return ask(listener, Action::kDisarm, GateState::kDisarmed);
  if (verb == "release") return ask(listener, Action::kRelease, GateState::kDisarmed);
  return show(listener);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The motor base: status, monitor, arm, disarm, stop, release (of the stop)."};
  std::string verb, lcm_url = kDefaultLcmUrl;
  double for_s = 0;
  app.add_option("verb", verb, "what to do")
      ->required()
      ->check(CLI::IsMember({"status", "monitor", "arm", "disarm", "stop", "release"}));
  app.add_option("--lcm-url", lcm_url, "the robot's bus")->capture_default_str();
  app.add_option("--for-s", for_s, "end monitor after so many seconds [s]")->check(CLI::PositiveNumber);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGTERM, [](int) { g_stop = 1; });
  std::signal(SIGINT, [](int) { g_stop = 1; });
  try {
    return run(verb, lcm_url, for_s);
  } catch (const InputError& error) {
    fmt::print(stderr, "base: {}\n", error.what());
    return 2;
  }
}
