// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Processes together in one lockstep executor: what replays and simulated missions run on.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/bus/lockstep.h"
#include "tools/stack/process_figures.h"

namespace arpent::tools {

class LockstepStack {
 public:
  LockstepStack(Time start, int threads) : executor_(start, threads) {}

  /// Constructs the process on the bus; it lives as long as the stack. Outputs of one moment commit in the order of
  /// addition. `prefix`: "R1/" puts it on that robot's bus.
  template <class Process>
  Process& add(const typename Process::Config& config, const std::string& prefix = "") {
    const auto [bus, clock] = executor_.add_process(Process::kName, prefix);
    auto process = std::make_shared<Process>(config, bus, clock);
    members_.push_back({prefix + Process::kName, &bus, process, [process] { process->finish(); }});
    return *process;
  }

  [[nodiscard]] LockstepExecutor& executor() { return executor_; }
  /// The orderly end of all, in the order of addition.
  void finish() {
    for (const Member& member : members_) member.finish();
  }
  [[nodiscard]] std::map<std::string, ProcessFigures> figures() const {
    std::map<std::string, ProcessFigures> all;
    for (const Member& member : members_) {
      const Health& health = member.bus->health();
      all[member.name] = {health.counters(), health.handler_ms(), health.messages()};
    }
    return all;
  }

 private:
  struct Member {
    std::string name;
    Bus* bus;
    std::shared_ptr<void> process;  // shared: `finish` holds it too
    std::function<void()> finish;
  };
  LockstepExecutor executor_;  // before the processes that live on its buses
  std::vector<Member> members_;
};

}  // namespace arpent::tools
