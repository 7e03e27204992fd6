// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/process/process.h"

#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <arpent/health_t.hpp>
#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>

#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/memory.h"
#include "common/process/real_time.h"

namespace arpent::detail {
namespace {

volatile std::sig_atomic_t g_stop = 0;  // set by the signal handler only

void on_signal(int /*signal*/) {
  g_stop = 1;
}

struct Flags {
  std::string robot = "R1";
  std::string config_file;
  std::string lcm_url = kDefaultLcmUrl;
  double run_for_s = 0;
  bool print_config = false;
  bool dry_run = false;
  std::vector<std::string> settings;
};

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

std::int64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0;
  std::int64_t resident = 0;
  statm >> size >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

health_t make_health(const std::string& name, Health& health, Time now, Time start) {
  health_t message{};
  message.utime = to_utime(now);
  message.process = name;
  message.pid = static_cast<std::int32_t>(getpid());
  message.uptime_s = to_seconds(now - start);
  message.cpu_s = cpu_seconds();
  message.resident_bytes = resident_bytes();
  const Health::Condition condition = health.take_condition();
  message.level = static_cast<std::int8_t>(condition.level);
  message.message = condition.message;
  for (const auto& [key, value] : health.counters()) {
    counter_t counter;
    counter.name = key;
    counter.value = value;
    message.counters.push_back(counter);
  }
  message.counter_count = static_cast<std::int32_t>(message.counters.size());
  if (!condition.message.empty()) {
    spdlog::log(condition.level == Health::Level::kError ? spdlog::level::err : spdlog::level::warn, "{}",
                condition.message);
  }
  return message;
}

void run(const ProcessType& type, const Flags& flags) {
  keep_freed_memory();
  // Before the bus: its threads inherit the schedule.
  const auto not_real_time = type.real_time ? enter_real_time() : std::nullopt;
  LcmBus bus(flags.lcm_url);
  const std::function<void()> finish = type.start(bus, bus);
  const Time start = bus.now();
  if (not_real_time) bus.health().warn(*not_real_time);
  const auto send_health = [&] {
    publish(bus, channels::kHealth, make_health(type.name, bus.health(), bus.now(), start));
  };
  bus.every(std::chrono::seconds(1), send_health);
  bus.start();
  send_health();
  spdlog::info("{} runs for {} on {}", type.name, flags.robot, flags.lcm_url);
  const auto until =
      std::chrono::steady_clock::now() + std::chrono::duration<double>(flags.run_for_s > 0 ? flags.run_for_s : 1e9);
  while (g_stop == 0 && std::chrono::steady_clock::now() < until) bus.run_for(std::chrono::milliseconds(50));
  finish();
  send_health();
  spdlog::info("{} ends", type.name);
}

}  // namespace

int run_process(const ProcessType& type, int argc, char** argv) {
  CLI::App app{type.help};
  Flags flags;
  app.add_option("--robot", flags.robot, "the robot's name")->capture_default_str();
  app.add_option("--config", flags.config_file, "configuration (YAML)");
  app.add_option("--set", flags.settings, "key=value, overrides the configuration; may be repeated");
  app.add_option("--lcm-url", flags.lcm_url, "the robot's bus")->capture_default_str();
  app.add_option("--run-for-s", flags.run_for_s, "end by itself after so many seconds [s]")->check(CLI::PositiveNumber);
  app.add_flag("--print-config", flags.print_config, "print every effective value with its origin, and end");
  if (type.has_dry_run) app.add_flag("--dry-run", flags.dry_run, "move nothing: listen and report only");
  app.set_version_flag("--version", ARPENT_VERSION);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  spdlog::set_default_logger(spdlog::stderr_logger_st(type.name));
  spdlog::set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
  std::signal(SIGTERM, on_signal);
  std::signal(SIGINT, on_signal);
  try {
    config::Sources sources;
    sources.file = flags.config_file;
    sources.text_name = type.name;
    sources.settings = flags.settings;
    if (flags.dry_run) sources.settings.emplace_back("dry_run=true");
    const config::Origins origins = type.load(sources);
    if (flags.print_config) {
      std::fputs(type.print(origins).c_str(), stdout);
      return 0;
    }
    run(type, flags);
    return 0;
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s: %s\n", type.name.c_str(), error.what());
    return 2;
  }
}

}  // namespace arpent::detail
