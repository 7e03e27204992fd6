// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Starts, watches, restarts and stops the processes of a live run, and gathers what they print in one log file, each
// line with its time and process.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

namespace arpent::tools {

struct ProcessSpec {
  std::string name;                  ///< for the log
  std::vector<std::string> command;  ///< executable and arguments
  bool restart = true;               ///< start it again when it ends by itself
  int network_fd = -1;               ///< the network namespace that it runs in; -1: the launcher's
};

class Launcher {
 public:
  using SteadyTime = std::chrono::steady_clock::time_point;

  struct Child {
    ProcessSpec spec;
    pid_t pid = -1;     ///< -1 when not running
    int exit_code = 0;  ///< of the last end; 128 + signal if killed
    int restarts = 0;
    bool gave_up = false;  ///< it ended more than 3 times within 10 s and is not started again
    bool killed = false;   ///< by kill()
    int output_fd = -1;
    std::string partial_line;
    std::vector<SteadyTime> ends;
  };

  /// Throws InputError if the log cannot be written.
  explicit Launcher(const std::filesystem::path& log_file);
  /// Stops what still runs.
  ~Launcher();
  Launcher(const Launcher&) = delete;
  Launcher& operator=(const Launcher&) = delete;

  /// Children die with the launcher; Ctrl-C on the terminal does not reach them. Throws InputError if the executable is
  /// not there.
  void start(const ProcessSpec& spec);
  /// Gathers output for at most `wait_ms`, reaps what ended and restarts it if wanted.
  void poll(int wait_ms);
  /// From now on what ends stays ended: for an orderly end, one after the other.
  void restart_no_more();
  /// Asks every process to end (SIGTERM, in reverse order of start), kills what is still there after `patience_ms`.
  /// Returns the number killed.
  int stop_all(int patience_ms);
  /// The same for one process; false if it had to be killed.
  bool stop(const std::string& name, int patience_ms);

  /// SIGKILL, as if the power went; it is not started again. Nothing if it does not run.
  void kill(const std::string& name);

  [[nodiscard]] const std::vector<Child>& children() const { return children_; }
  [[nodiscard]] bool running(const std::string& name) const;

 private:
  void spawn(Child& child);
  void reap();
  void on_end(Child& child, int status);
  void finish_off(Child& child);
  void gather(int wait_ms);
  void write_lines(Child& child, const char* data, std::size_t size);
  void log(const std::string& name, const std::string& line);

  std::ofstream log_;
  SteadyTime start_;
  std::vector<Child> children_;
};

}  // namespace arpent::tools
