// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/team/radio_lab.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <arpent/health_t.hpp>
#include <future>
#include <map>
#include <mutex>
#include <thread>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"

namespace arpent::tools {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr char kUrl[] = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";

/// Starts a program in the network of the calling thread.
pid_t spawn(const std::vector<std::string>& command, const fs::path& output) {
  std::vector<char*> argv;
  for (const std::string& word : command) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, output.c_str(), O_CREAT | O_APPEND | O_WRONLY, 0600);
  pid_t pid = -1;
  const int refused = posix_spawn(&pid, argv.front(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused != 0) throw InputError("cannot start " + command.front());
  return pid;
}

/// Asks it to end, and kills it if it does not within 3 s.
void end(pid_t& pid, int signal) {
  if (pid <= 0) return;
  kill(pid, signal);
  for (int i = 0; i < 300 && waitpid(pid, nullptr, WNOHANG) == 0; ++i) {
    if (i == 299) kill(pid, SIGKILL);
    std::this_thread::sleep_for(10ms);
  }
  pid = -1;
}

}  // namespace

/// A station: its thread lives in its network, serves its bus, and starts its link.
struct RadioLab::Member {
  std::vector<std::string> command;
  fs::path output;
  pid_t pid = -1;
  int tap_fd = -1;
  std::unique_ptr<LcmBus> bus;
  std::mutex mutex;
  std::vector<std::packaged_task<void()>> tasks;  // guarded by mutex
  std::map<std::string, std::int64_t> counters;   // guarded by mutex
  std::jthread thread;

  void enter(int number, const std::function<void(LcmBus&)>& subscribe_more) {
    const Result<int> tap = enter_radio_network("10.77.0." + std::to_string(number + 1));
    if (!tap) throw InputError("no network for a station: " + tap.fault());
    tap_fd = *tap;
    bus = std::make_unique<LcmBus>(kUrl);
    subscribe<health_t>(*bus, channels::kHealth, {}, [this](const health_t& health) {
      const std::lock_guard lock(mutex);
      counters.clear();
      for (const auto& counter : health.counters) counters[counter.name] = counter.value;
    });
    subscribe_more(*bus);
    bus->start();
  }

  void serve(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      bus->run_for(5ms);
      std::vector<std::packaged_task<void()>> now;
      {
        const std::lock_guard lock(mutex);
        now.swap(tasks);
      }
      for (auto& task : now) task();
    }
    end(pid, SIGTERM);
  }

  /// In the station's thread; returns when it is done.
  void run(std::function<void()> work) {
    std::packaged_task<void()> task(std::move(work));
    std::future<void> done = task.get_future();
    {
      const std::lock_guard lock(mutex);
      tasks.push_back(std::move(task));
    }
    done.get();
  }
};

RadioLab::RadioLab(const std::vector<LabStation>& stations, const AirParams& air, const fs::path& bin,
                   const fs::path& scratch, const std::function<void(int, LcmBus&)>& subscribe)
    : air_(std::make_unique<TapHub>(air, 1)) {
  for (const LabStation& station : stations) {
    const int number = static_cast<int>(members_.size());
    Member& member = *members_.emplace_back(std::make_unique<Member>());
    member.output = scratch / (station.name + ".log");
    member.command = {(bin / "team_link_process").string(),
                      "--robot",
                      station.name,
                      "--lcm-url",
                      kUrl,
                      "--run-for-s",
                      "600"};  // should the lab crash
    std::vector<std::string> settings{"station=" + station.name, "role=" + station.role, "link.interface=radio0"};
    settings.push_back(station.keys.empty() ? "link.security=off" : "link.keys=" + station.keys.string());
    settings.insert(settings.end(), station.settings.begin(), station.settings.end());
    for (const std::string& setting : settings) member.command.insert(member.command.end(), {"--set", setting});
    std::promise<void> entered;
    std::future<void> ready = entered.get_future();
    member.thread =
        std::jthread([&member, number, &subscribe, promise = std::move(entered)](const std::stop_token& stop) mutable {
          try {
            member.enter(number, [&](LcmBus& bus) { subscribe(number, bus); });
            promise.set_value();
          } catch (...) {
            promise.set_exception(std::current_exception());
            return;
          }
          member.serve(stop);
        });
    ready.get();
    air_->attach(member.tap_fd);
  }
}

RadioLab::~RadioLab() {
  for (const auto& member : members_) member->thread.request_stop();
  members_.clear();
}

TapHub& RadioLab::air() {
  return *air_;
}

Bus& RadioLab::bus(int station) {
  return *members_[static_cast<std::size_t>(station)]->bus;
}

void RadioLab::start_link(int station) {
  Member& member = *members_[static_cast<std::size_t>(station)];
  member.run([&member] { member.pid = spawn(member.command, member.output); });
}

void RadioLab::kill_link(int station) {
  Member& member = *members_[static_cast<std::size_t>(station)];
  member.run([&member] { end(member.pid, SIGKILL); });
}

std::int64_t RadioLab::counter(int station, const std::string& name) const {
  Member& member = *members_[static_cast<std::size_t>(station)];
  const std::lock_guard lock(member.mutex);
  const auto found = member.counters.find(name);
  return found == member.counters.end() ? 0 : found->second;
}

}  // namespace arpent::tools
