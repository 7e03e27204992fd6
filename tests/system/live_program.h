// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A program as a user starts it, for live tests: its words, what it says, its end.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace arpent {

/// Whether it comes true in time.
template <class Done>
bool wait_until(Done done, std::chrono::seconds limit) {
  const auto until = std::chrono::steady_clock::now() + limit;
  while (std::chrono::steady_clock::now() < until) {
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return done();
}

class LiveProgram {
 public:
  /// What it prints goes into `said`.
  explicit LiveProgram(std::filesystem::path said) : said_(std::move(said)) {}
  ~LiveProgram() { end(); }
  LiveProgram(const LiveProgram&) = delete;
  LiveProgram& operator=(const LiveProgram&) = delete;

  void start(std::vector<std::string> words) {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    const int said = open(said_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(said, STDOUT_FILENO);
    dup2(said, STDERR_FILENO);
    execv(argv[0], argv.data());
    _exit(127);
  }
  /// What it has printed so far.
  [[nodiscard]] std::string said() const {
    std::stringstream text;
    text << std::ifstream(said_).rdbuf();
    return text.str();
  }
  /// At once, if it still runs.
  void end() {
    if (pid_ > 0) kill(pid_, SIGKILL);
    pid_ = -1;
  }
  void interrupt() const { kill(pid_, SIGINT); }
  /// Its exit code; -1 if it does not end.
  int exit_code(std::chrono::seconds limit) {
    int status = 0;
    if (!wait_until([&] { return waitpid(pid_, &status, WNOHANG) == pid_; }, limit)) return -1;
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  std::filesystem::path said_;
  pid_t pid_ = -1;
};

}  // namespace arpent
