// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/net/radio_network.h"

#include <fcntl.h>
#include <sched.h>
#include <unistd.h>

#include <exception>
#include <thread>
#include <utility>

#include "common/error.h"
#include "common/net/interface.h"
#include "common/net/tap_hub.h"

namespace arpent {
namespace {

/// In a thread of its own, which takes nothing of where it has been along.
void run_aside(const std::function<void()>& work) {
  std::exception_ptr thrown;
  std::thread([&] {
    try {
      work();
    } catch (...) {
      thrown = std::current_exception();
    }
  }).join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace

void run_in_network(int network_fd, const std::function<void()>& work) {
  if (network_fd < 0) return work();
  run_aside([&] {
    if (setns(network_fd, CLONE_NEWNET) != 0)
      throw InputError("cannot enter a station's network: " + net_fault("setns"));
    work();
  });
}

RadioNetwork::RadioNetwork(const std::string& ipv4) {
  run_aside([&] {
    const Result<int> tap = enter_radio_network(ipv4);
    if (!tap) throw InputError("no network for a station: " + tap.fault());
    tap_fd_ = *tap;
    network_fd_ = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
    if (network_fd_ >= 0) return;
    close(tap_fd_);
    throw InputError("no network for a station: " + net_fault("its namespace"));
  });
}

RadioNetwork::~RadioNetwork() {
  if (tap_fd_ >= 0) close(tap_fd_);
  close(network_fd_);
}

int RadioNetwork::release_tap() {
  return std::exchange(tap_fd_, -1);
}

}  // namespace arpent
