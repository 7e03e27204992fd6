// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/launcher.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include <fmt/format.h>
#include "common/error.h"

namespace arpent::tools {
namespace {

using namespace std::chrono_literals;

constexpr int kMaxEnds = 3;
constexpr auto kCrashLoopWindow = 10s;

/// Holds all signals back while it lives, so that none reaches a child before it has handlers of its own.
class SignalsHeld {
 public:
  SignalsHeld() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsHeld(const SignalsHeld&) = delete;
  SignalsHeld& operator=(const SignalsHeld&) = delete;

 private:
  sigset_t before_{};
};

/// A process group of its own: Ctrl-C on the terminal reaches only the launcher, which then stops all in order.
[[noreturn]] void become(const ProcessSpec& spec, int output_fd, pid_t parent) {
  setpgid(0, 0);
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) signal(number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  pthread_sigmask(SIG_SETMASK, &none, nullptr);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(127);
  if (spec.network_fd >= 0 && setns(spec.network_fd, CLONE_NEWNET) != 0) _exit(126);
  dup2(output_fd, STDOUT_FILENO);
  dup2(output_fd, STDERR_FILENO);
  std::vector<char*> arguments;
  for (const std::string& word : spec.command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  _exit(127);
}

}  // namespace

Launcher::Launcher(const std::filesystem::path& log_file) : log_(log_file), start_(std::chrono::steady_clock::now()) {
  if (!log_) throw InputError("cannot write the launcher's log " + log_file.string());
}

Launcher::~Launcher() {
  stop_all(3000);
}

void Launcher::start(const ProcessSpec& spec) {
  ARPENT_ASSERT(!spec.command.empty());
  const std::string& executable = spec.command.front();
  if (executable.find('/') != std::string::npos && access(executable.c_str(), X_OK) != 0) {
    throw InputError("cannot start " + spec.name + ": " + executable + " is not there or not executable");
  }
  children_.push_back({spec, -1, 0, 0, false, false, -1, "", {}});
  spawn(children_.back());
}

void Launcher::spawn(Child& child) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw InputError("cannot start " + child.spec.name + ": no pipe");
  const pid_t parent = getpid();
  const SignalsHeld held;
  const pid_t pid = fork();
  if (pid == 0) become(child.spec, ends[1], parent);
  close(ends[1]);
  if (pid < 0) {
    close(ends[0]);
    throw InputError("cannot start " + child.spec.name + ": fork failed");
  }
  child.pid = pid;
  child.output_fd = ends[0];
  fcntl(child.output_fd, F_SETFL, O_NONBLOCK);
  log(child.spec.name, fmt::format("started, pid {}", pid));
}

void Launcher::poll(int wait_ms) {
  gather(wait_ms);
  reap();
}

void Launcher::gather(int wait_ms) {
  std::vector<pollfd> wanted;
  std::vector<Child*> owners;
  for (Child& child : children_) {
    if (child.output_fd < 0) continue;
    wanted.push_back({child.output_fd, POLLIN, 0});
    owners.push_back(&child);
  }
  if (::poll(wanted.data(), wanted.size(), wait_ms) <= 0) return;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i].revents == 0) continue;
    char buffer[4096];
    const ssize_t count = read(owners[i]->output_fd, buffer, sizeof buffer);
    if (count > 0) {
      write_lines(*owners[i], buffer, static_cast<std::size_t>(count));
    } else if (count == 0 || errno != EAGAIN) {
      close(owners[i]->output_fd);
      owners[i]->output_fd = -1;
    }
  }
}

void Launcher::write_lines(Child& child, const char* data, std::size_t size) {
  child.partial_line.append(data, size);
  for (auto end = child.partial_line.find('\n'); end != std::string::npos; end = child.partial_line.find('\n')) {
    log(child.spec.name, child.partial_line.substr(0, end));
    child.partial_line.erase(0, end + 1);
  }
}

void Launcher::log(const std::string& name, const std::string& line) {
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start_;
  log_ << fmt::format("{:10.3f} {:18} {}\n", elapsed.count(), name, line) << std::flush;
}

void Launcher::reap() {
  for (Child& child : children_) {
    int status = 0;
    if (child.pid > 0 && waitpid(child.pid, &status, WNOHANG) == child.pid) {
      on_end(child, status);
      if (child.spec.restart && !child.gave_up) {
        ++child.restarts;
        spawn(child);
      }
    }
  }
}

void Launcher::on_end(Child& child, int status) {
  gather(0);
  if (child.output_fd >= 0) close(child.output_fd);
  child.output_fd = -1;
  child.pid = -1;
  child.exit_code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  log(child.spec.name, fmt::format("ended with code {}", child.exit_code));
  const auto now = std::chrono::steady_clock::now();
  std::erase_if(child.ends, [&](SteadyTime end) { return now - end > kCrashLoopWindow; });
  child.ends.push_back(now);
  child.gave_up = static_cast<int>(child.ends.size()) > kMaxEnds;
  if (child.gave_up && child.spec.restart) log(child.spec.name, "ends again and again: not started any more");
}

bool Launcher::running(const std::string& name) const {
  return std::any_of(children_.begin(), children_.end(),
                     [&](const Child& child) { return child.spec.name == name && child.pid > 0; });
}

void Launcher::restart_no_more() {
  for (Child& child : children_) child.spec.restart = false;
}

bool Launcher::stop(const std::string& name, int patience_ms) {
  bool willing = true;
  for (Child& child : children_) {
    if (child.spec.name != name || child.pid <= 0) continue;
    child.spec.restart = false;
    ::kill(child.pid, SIGTERM);
    const auto limit = std::chrono::steady_clock::now() + std::chrono::milliseconds(patience_ms);
    while (child.pid > 0 && std::chrono::steady_clock::now() < limit) poll(20);
    if (child.pid <= 0) continue;
    willing = false;
    log(child.spec.name, "does not end: killed");
    finish_off(child);
  }
  return willing;
}

void Launcher::finish_off(Child& child) {
  ::kill(child.pid, SIGKILL);
  int status = 0;
  waitpid(child.pid, &status, 0);
  on_end(child, status);
}

void Launcher::kill(const std::string& name) {
  for (Child& child : children_) {
    if (child.spec.name != name) continue;
    child.spec.restart = false;
    child.killed = true;
    if (child.pid > 0) finish_off(child);
  }
}

int Launcher::stop_all(int patience_ms) {
  int killed = 0;
  restart_no_more();
  for (auto child = children_.rbegin(); child != children_.rend(); ++child) {
    if (child->pid > 0 && !stop(child->spec.name, patience_ms)) ++killed;
  }
  return killed;
}

}  // namespace arpent::tools
