// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The live bus: LCM over UDP multicast on this machine. A reader thread empties LCM into bounded queues of our own, so
// that every message displaced by a slow handler is counted; handlers run in the thread that calls run_for(), one at a
// time, in order of arrival. Timers run there too.
#pragma once

#include <memory>
#include <string>

#include "common/bus/bus.h"

namespace arpent {

/// Default address of a robot's bus: loopback only (ttl 0) and a receive buffer that holds several stereo pairs.
inline constexpr const char* kDefaultLcmUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4194304";

class LcmBus : public Bus, public Clock {
 public:
  /// Throws InputError, saying what to do, if the bus cannot be opened (most often: no route for multicast).
  explicit LcmBus(const std::string& url);
  ~LcmBus() override;

  void publish_bytes(const std::string& channel, BytesView bytes) override;
  void subscribe_bytes(const std::string& channel, const SubscriptionOptions& options, RawHandler handler) override;
  /// Microseconds of the monotonic clock, on the epoch's date at the start.
  [[nodiscard]] Time now() const override;
  void every(Duration period, std::function<void()> callback) override;

  /// Starts receiving: call after the subscriptions.
  void start();
  /// Handles messages and timers for at most `duration`; returns early after at least one was handled.
  void run_for(Duration duration);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
