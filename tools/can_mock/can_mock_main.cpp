// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `./arpent can-mock`: the firmware of a chassis as a process, for a stack without a robot. Events come from --at and
// from standard input, a line each.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "common/error.h"
#include "tools/can_mock/mock.h"

namespace {

using namespace arpent;

constexpr Duration kStep{5000};
volatile std::sig_atomic_t g_stop = 0;  // set by the signal handler only

Time steady_now() {
  return Time(std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch()));
}

/// Lines that have come on standard input; none after its end.
class InputLines {
 public:
  std::vector<std::string> take() {
    std::vector<std::string> lines;
    pollfd ready{STDIN_FILENO, POLLIN, 0};
    char chunk[512];
    while (open_ && poll(&ready, 1, 0) == 1) {
      const ssize_t size = read(STDIN_FILENO, chunk, sizeof(chunk));
      open_ = size > 0;
      if (open_) waiting_.append(chunk, static_cast<std::size_t>(size));
    }
    for (std::size_t end = 0; (end = waiting_.find('\n')) != std::string::npos; waiting_.erase(0, end + 1)) {
      lines.push_back(waiting_.substr(0, end));
    }
    return lines;
  }

 private:
  bool open_ = true;
  std::string waiting_;
};

struct TimedEvent {
  double at_s;
  std::string event;
};

TimedEvent parse_timed(const std::string& text) {
  const std::size_t colon = text.find(':');
  const auto at_s = tools::to_number(text.substr(0, colon));
  if (colon == std::string::npos || !at_s || *at_s < 0) {
    throw InputError("can-mock: --at '" + text + "': must be SECONDS:EVENT");
  }
  return {*at_s, text.substr(colon + 1)};
}

void run(tools::Mock& mock, std::vector<TimedEvent> timed, double run_for_s, bool quiet) {
  const Time start = steady_now();
  Time last = start, told = start;
  InputLines input;
  const auto apply = [&](const std::string& event) {
    if (!mock.apply(event))
      fmt::print(stderr, "can-mock: event '{}' is not understood: {}\n", event, tools::kEventHelp);
  };
  while (g_stop == 0 && (run_for_s <= 0 || to_seconds(steady_now() - start) < run_for_s)) {
    mock.wait(kStep);
    const Time now = steady_now();
    for (const std::string& line : input.take()) apply(line);
    std::erase_if(timed, [&](const TimedEvent& event) {
      const bool due = to_seconds(now - start) >= event.at_s;
      if (due) apply(event.event);
      return due;
    });
    // A chassis that was held up moves on by what its motors could do meanwhile, 20 ms at most.
    mock.step(now, std::min(to_seconds(now - last), 0.02));
    last = now;
    if (quiet || now - told < std::chrono::seconds(1)) continue;
    told = now;
    const Twist2 twist = mock.motors().ground_twist();
    fmt::print("{:7.1f} s  {:+.3f} m/s  {:+.3f} rad/s  {}\n", to_seconds(now - start), twist.speed_mps,
               twist.turn_rate_radps, mock.condition());
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"A chassis' firmware as a process. Events (--at and standard input): " + std::string(tools::kEventHelp)};
  tools::MockOptions options;
  std::string robot_file, protocol;
  std::vector<std::string> timed_texts, settings;
  double run_for_s = 0;
  bool quiet = false;
  app.add_option("--listen", options.listen,
                 "agilex_v2: socket:PATH or a CAN interface; wifibot: tcp:PORT, udp:PORT or serial:LINK")
      ->required();
  app.add_option("--protocol", protocol, "agilex_v2 or wifibot; else the robot file's")
      ->check(CLI::IsMember({"agilex_v2", "wifibot"}));
  app.add_option("--robot", robot_file, "robot file: protocol, geometry and units")->check(CLI::ExistingFile);
  app.add_option("--set", settings, "key=value of the motors, e.g. lag_s=0.2; may be repeated");
  app.add_option("--at", timed_texts, "SECONDS:EVENT; may be repeated");
  app.add_option("--run-for-s", run_for_s, "end by itself after so many seconds [s]")->check(CLI::PositiveNumber);
  app.add_flag("--quiet", quiet, "no line a second");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  std::signal(SIGTERM, [](int) { g_stop = 1; });
  std::signal(SIGINT, [](int) { g_stop = 1; });
  try {
    if (!robot_file.empty()) options.base = config::load<RobotConfig>(robot_file).base;
    if (!protocol.empty()) options.base.protocol = protocol;
    options.motors.geometry = options.base.geometry;
    config::read(options.motors, {.text_name = "motors", .settings = settings});
    std::vector<TimedEvent> timed;
    for (const std::string& text : timed_texts) timed.push_back(parse_timed(text));
    run(*tools::make_mock(options, steady_now), std::move(timed), run_for_s, quiet);
    return 0;
  } catch (const InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 2;
  }
}
