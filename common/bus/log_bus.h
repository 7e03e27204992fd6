// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A log file as a bus: one process handles the events of a log, in the order of the file, and what it publishes goes to
// another log. The clock is the log's. For tools that need one process over one log; several at once are the lockstep
// executor's business.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "common/bus/bus.h"
#include "common/log/event_log.h"

namespace arpent {

class LogBus : public Bus, public Clock {
 public:
  /// `out` empty: what is published goes nowhere. Throws InputError if a file cannot be opened.
  LogBus(const std::filesystem::path& in, const std::filesystem::path& out);

  /// Written at the time of the event being handled.
  void publish_bytes(const std::string& channel, BytesView bytes) override;
  void subscribe_bytes(const std::string& channel, const SubscriptionOptions& options, RawHandler handler) override;
  /// Never goes back, even where the log's times do.
  [[nodiscard]] Time now() const override { return now_; }
  void every(Duration period, std::function<void()> callback) override;

  /// Handles all events. Throws InputError if the output is not wholly on disk.
  void run();
  [[nodiscard]] const LogDamage& damage() const { return reader_.damage(); }

 private:
  struct Subscription {
    std::string channel;
    SubscriptionOptions options;
    RawHandler handler;
  };
  struct Timer {
    Duration period;
    std::function<void()> callback;
    Time next;
  };
  void ring_until(Time time);

  LogReader reader_;
  std::unique_ptr<LogWriter> writer_;
  std::vector<Subscription> subscriptions_;
  std::vector<Timer> timers_;
  Time now_{};
};

}  // namespace arpent
