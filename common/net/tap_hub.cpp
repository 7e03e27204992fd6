// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/net/tap_hub.h"

#include <fcntl.h>
#include <linux/if_tun.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <thread>
#include <vector>

#include "common/net/interface.h"
#include "common/net/private_network.h"

namespace arpent {
namespace {

using Steady = std::chrono::steady_clock;
using Mac = std::array<std::uint8_t, 6>;
using Frame = std::vector<std::uint8_t>;

constexpr char kInterface[] = "radio0";
constexpr std::size_t kMaxFrame = 2048;

int open_tap() {
  const int fd = open("/dev/net/tun", O_RDWR | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return -1;
  ifreq request{};
  std::strncpy(request.ifr_name, kInterface, IFNAMSIZ - 1);
  request.ifr_flags = IFF_TAP | IFF_NO_PI;
  if (ioctl(fd, TUNSETIFF, &request) == 0) return fd;
  close(fd);
  return -1;
}

bool is_ipv6(const Frame& frame) {
  return frame[12] == 0x86 && frame[13] == 0xdd;
}

Mac mac_at(const Frame& frame, std::size_t offset) {
  Mac mac{};
  std::copy_n(frame.begin() + static_cast<std::ptrdiff_t>(offset), mac.size(), mac.begin());
  return mac;
}

}  // namespace

std::string radio_network_refused() {
  // As an ordinary user this makes a user namespace, which later permits each thread a network of its own.
  static const std::string reason = enter_private_network();
  if (!reason.empty()) return reason;
  return access("/dev/net/tun", R_OK | W_OK) == 0 ? "" : "/dev/net/tun is not accessible";
}

Result<int> enter_radio_network(const std::string& ipv4) {
  if (std::string reason = enter_private_network(); !reason.empty()) return Fault{std::move(reason)};
  return open_radio_interface(ipv4);
}

Result<int> open_radio_interface(const std::string& ipv4) {
  const int tap_fd = open_tap();
  if (tap_fd < 0) return Fault{net_fault("a TAP interface")};
  std::string reason = configure_network("address of a TAP interface", [&](int socket_fd) {
    return set_address(socket_fd, kInterface, ipv4, "255.255.255.0") && bring_up(socket_fd, kInterface);
  });
  if (reason.empty()) return tap_fd;
  close(tap_fd);
  return Fault{std::move(reason)};
}

struct TapHub::State {
  struct Port {
    int fd;
    bool cut = false;
    Steady::time_point up_free{}, down_free{};
  };
  struct Flight {
    std::size_t to;
    Frame frame;
  };

  AirParams air;
  std::mt19937_64 random;
  mutable std::mutex mutex;
  std::vector<Port> ports;  // guarded, as all below
  std::map<Mac, std::size_t> learned;
  std::multimap<Steady::time_point, Flight> in_flight;  // equal times keep their order
  Traffic traffic;
  std::function<void(int, std::span<const std::uint8_t>)> watcher;
  std::jthread thread;

  [[nodiscard]] Steady::duration on_line(std::size_t bytes) const {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(8e3 * static_cast<double>(bytes) / air.rate_mbps));
  }
  [[nodiscard]] static Steady::duration seconds(double s) {
    return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * s));
  }
  bool lost() { return static_cast<double>(random() >> 11) * 0x1p-53 < air.loss; }

  /// When a frame has gone through a line that is free from `free` on; the line's queue may be full.
  bool pass(Steady::time_point& free, Steady::time_point& at, std::size_t bytes) {
    const Steady::time_point begin = std::max(free, at);
    if (begin - at > seconds(air.queue_s)) {
      ++traffic.dropped;
      return false;
    }
    at = free = begin + on_line(bytes);
    return true;
  }

  void send(std::size_t from, const Frame& frame, Steady::time_point now) {
    if (is_ipv6(frame)) return;
    ++traffic.frames;
    traffic.bytes += static_cast<std::int64_t>(frame.size());
    learned[mac_at(frame, 6)] = from;
    if (watcher) watcher(static_cast<int>(from), frame);
    Steady::time_point at = now;
    if (ports[from].cut || !pass(ports[from].up_free, at, frame.size())) return;
    const auto known = learned.find(mac_at(frame, 0));
    for (std::size_t to = 0; to < ports.size(); ++to) {
      if (to == from || ports[to].cut || (known != learned.end() && known->second != to) || lost()) continue;
      Steady::time_point arrival = at + seconds(air.delay_s);
      if (pass(ports[to].down_free, arrival, frame.size())) in_flight.emplace(arrival, Flight{to, frame});
    }
  }

  void read_all(Steady::time_point now) {
    Frame frame(kMaxFrame);
    for (std::size_t from = 0; from < ports.size(); ++from) {
      for (ssize_t size = 0; (size = read(ports[from].fd, frame.data(), kMaxFrame)) >= 14;) {
        frame.resize(static_cast<std::size_t>(size));
        send(from, frame, now);
        frame.resize(kMaxFrame);
      }
    }
  }

  void deliver(Steady::time_point now) {
    while (!in_flight.empty() && in_flight.begin()->first <= now) {
      const Flight& flight = in_flight.begin()->second;
      const Port& port = ports[flight.to];
      if (!port.cut && write(port.fd, flight.frame.data(), flight.frame.size()) < 0) ++traffic.dropped;
      in_flight.erase(in_flight.begin());
    }
  }

  /// Sleeps until a frame comes, one is due, or 20 ms have passed (a station may have been attached).
  void wait() {
    std::vector<pollfd> watched;
    Steady::duration sleep = std::chrono::milliseconds(20);
    {
      const std::lock_guard lock(mutex);
      for (const Port& port : ports) watched.push_back({port.fd, POLLIN, 0});
      if (!in_flight.empty()) sleep = std::min(sleep, in_flight.begin()->first - Steady::now());
    }
    const auto ns = std::max<std::int64_t>(0, std::chrono::duration_cast<std::chrono::nanoseconds>(sleep).count());
    const timespec limit{ns / 1000000000, ns % 1000000000};
    ppoll(watched.data(), watched.size(), &limit, nullptr);
  }

  void run(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      wait();
      const std::lock_guard lock(mutex);
      read_all(Steady::now());
      deliver(Steady::now());
    }
  }
};

TapHub::TapHub(const AirParams& air, std::uint64_t seed) : state_(std::make_unique<State>()) {
  state_->air = air;
  state_->random.seed(seed);
  state_->thread = std::jthread([state = state_.get()](const std::stop_token& stop) { state->run(stop); });
}

TapHub::~TapHub() {
  state_->thread.request_stop();
  state_->thread.join();
  for (const State::Port& port : state_->ports) close(port.fd);
}

int TapHub::attach(int tap_fd) {
  const std::lock_guard lock(state_->mutex);
  state_->ports.push_back({tap_fd});
  return static_cast<int>(state_->ports.size()) - 1;
}

void TapHub::set_loss(double loss) {
  const std::lock_guard lock(state_->mutex);
  state_->air.loss = loss;
}

void TapHub::cut(int station, bool off) {
  const std::lock_guard lock(state_->mutex);
  state_->ports[static_cast<std::size_t>(station)].cut = off;
}

void TapHub::watch(std::function<void(int, std::span<const std::uint8_t>)> watcher) {
  const std::lock_guard lock(state_->mutex);
  state_->watcher = std::move(watcher);
}

TapHub::Traffic TapHub::traffic() const {
  const std::lock_guard lock(state_->mutex);
  return state_->traffic;
}

}  // namespace arpent
