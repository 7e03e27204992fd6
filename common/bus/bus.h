// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The bus as a process sees it: bytes on named channels, and a clock with timers. Three things implement it: LCM over
// UDP multicast (lcm_bus.h), the in-memory bus of the lockstep executor (lockstep.h), and a log file (log_bus.h). Typed
// messages are a layer above (typed.h). A bus belongs to one process; the health that it counts is that process' own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/bus/health.h"
#include "common/time.h"

namespace arpent {

using Bytes = std::vector<std::uint8_t>;
using BytesView = std::span<const std::uint8_t>;

struct SubscriptionOptions {
  /// Messages that may wait; when one more arrives the oldest is dropped and counted.
  int queue_capacity = 8;
  /// A larger message is refused unseen and counted.
  std::size_t max_bytes = std::size_t{16} << 20;
  /// Declared time from the message to what its handler publishes. In lockstep the outputs appear that much later and
  /// the process is busy meanwhile (not if it publishes nothing); live it is only compared with what is measured.
  Duration latency = Duration(0);
};

class Bus {
 public:
  using RawHandler = std::function<void(BytesView)>;

  virtual ~Bus() = default;
  virtual void publish_bytes(const std::string& channel, BytesView bytes) = 0;
  /// Handlers of one bus never run at the same time. Call only before the executor runs.
  virtual void subscribe_bytes(const std::string& channel, const SubscriptionOptions& options, RawHandler handler) = 0;

  [[nodiscard]] Health& health() { return health_; }
  [[nodiscard]] const Health& health() const { return health_; }

 private:
  Health health_;
};

/// The only source of time for a process. Measurements carry their own stamps; the clock is for timers and health.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual Time now() const = 0;
  /// Calls `callback` each `period`, the first time one period from now. A timer is an event like a message.
  virtual void every(Duration period, std::function<void()> callback) = 0;
};

}  // namespace arpent
