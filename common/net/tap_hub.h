// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A radio for live tests and benches: network namespaces, one for each station, joined by a hub in this process that
// loses, delays and limits Ethernet frames (the kernel needs no netem). Nothing leaves the machine. Links of different
// senders do not share the air: each station has a rate of its own, up and down. The stations speak IPv4: what the
// kernel says of itself in IPv6 is neither carried nor counted.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "common/result.h"

namespace arpent {

/// Why this machine permits no radio network, empty if it does: then the process has moved into a network of its own.
/// To be called before any thread is started.
[[nodiscard]] std::string radio_network_refused();

/// As enter_private_network(), with one more interface, `radio0`, that has this address (/24). The frames of that
/// interface come and go through the returned file descriptor, which the caller owns. The calling thread alone moves,
/// if the system permits that to a thread (as root, or after the process has moved).
[[nodiscard]] Result<int> enter_radio_network(const std::string& ipv4);

/// Only the interface, in the network that the thread is in.
[[nodiscard]] Result<int> open_radio_interface(const std::string& ipv4);

struct AirParams {
  double loss = 0;  ///< of each frame, at each receiver by itself
  double delay_s = 0.02;
  double rate_mbps = 50;
  double queue_s = 0.1;  ///< what would wait longer is dropped
};

class TapHub {
 public:
  TapHub(const AirParams& air, std::uint64_t seed);
  ~TapHub();

  /// Takes a station's descriptor over; its number counts from 0.
  int attach(int tap_fd);
  void set_loss(double loss);
  /// Nothing comes from or to the station while it is cut off.
  void cut(int station, bool off);

  /// `watcher` gets every frame that a station sends, in the hub's thread.
  void watch(std::function<void(int station, std::span<const std::uint8_t> frame)> watcher);

  struct Traffic {
    std::int64_t frames = 0;
    std::int64_t bytes = 0;    ///< Ethernet headers included, each frame once however many hear it
    std::int64_t dropped = 0;  ///< because a queue was full
  };
  [[nodiscard]] Traffic traffic() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
