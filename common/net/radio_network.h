// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A station's network namespace with an interface on the radio (tap_hub.h), kept open so that work and processes can
// enter it: one station of several on one machine.
#pragma once

#include <functional>
#include <string>

namespace arpent {

/// Does `work` in a thread that is in the network of `network_fd` (-1: in the caller's), and waits for it. Sockets that
/// it opens stay there. Throws what `work` throws.
void run_in_network(int network_fd, const std::function<void()>& work);

class RadioNetwork {
 public:
  /// Makes it; `ipv4` (/24) is its address on the radio. radio_network_refused() must have been asked. Throws
  /// InputError if the system refuses.
  explicit RadioNetwork(const std::string& ipv4);
  ~RadioNetwork();
  RadioNetwork(const RadioNetwork&) = delete;
  RadioNetwork& operator=(const RadioNetwork&) = delete;

  /// The namespace, good while this lives.
  [[nodiscard]] int network_fd() const { return network_fd_; }
  /// The frames of its interface come and go through it; the caller owns it from now on (TapHub::attach).
  [[nodiscard]] int release_tap();

 private:
  int network_fd_ = -1, tap_fd_ = -1;
};

}  // namespace arpent
