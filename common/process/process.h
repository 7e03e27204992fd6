// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The skeleton of every process: flags, configuration, the live bus, shut-down by signal, one health message a second.
// A process' main is `return run_process<XxxProcess>(argc, argv);`. The process class needs `Config` (self-describing,
// config/fields.h), `kName`, `kHelp`, a constructor from (const Config&, Bus&, Clock&), and `finish()` for an orderly
// end. With `kRealTime` it runs under SCHED_FIFO if it may; a `dry_run` in its Config gives it the flag --dry-run.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/config.h"

namespace arpent {

namespace detail {

/// What run_process knows of a process' type.
struct ProcessType {
  std::string name;
  std::string help;
  bool real_time = false;
  bool has_dry_run = false;  ///< its config has `dry_run`
  std::function<config::Origins(const config::Sources&)> load;
  std::function<std::string(const config::Origins&)> print;
  /// Constructs the process on the bus; the returned function is its finish().
  std::function<std::function<void()>(Bus&, Clock&)> start;
};

int run_process(const ProcessType& type, int argc, char** argv);

}  // namespace detail

/// Runs the process until SIGTERM, SIGINT or the end of --run-for-s. Exit code 0 after an orderly end, 2 with one clear
/// line per fault in arguments, config or bus.
template <class Process>
int run_process(int argc, char** argv) {
  typename Process::Config config;
  std::unique_ptr<Process> process;
  detail::ProcessType type;
  type.name = Process::kName;
  type.help = Process::kHelp;
  if constexpr (requires { Process::kRealTime; }) type.real_time = Process::kRealTime;
  type.has_dry_run = requires {
    config.dry_run;
  };
  type.load = [&config](const config::Sources& sources) { return config::read(config, sources); };
  type.print = [&config](const config::Origins& origins) { return config::to_yaml(config, origins); };
  type.start = [&](Bus& bus, Clock& clock) {
    process = std::make_unique<Process>(config, bus, clock);
    return [&process] { process->finish(); };
  };
  return detail::run_process(type, argc, argv);
}

}  // namespace arpent
