// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a process knows about its own condition: named counters, the worst level since it was last asked, and how long
// its handlers took. The skeleton publishes it once a second as health_t; reports and tests read it directly.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace arpent {

class Health {
 public:
  enum class Level : std::int8_t { kOk = 0, kWarning = 1, kError = 2 };

  /// Adds to counter `CHANNEL.what`. The vocabulary of subscriptions: received, handled, undecodable (size,
  /// fingerprint, counts), invalid (decoded, but refused by the room's wire), dropped (displaced in a full queue), lost
  /// (gaps in the source's sequence, whatever the cause: it includes the dropped ones), failed (the handler threw).
  void count(std::string_view channel, std::string_view what, std::int64_t increment = 1);
  void warn(const std::string& message) { raise(Level::kWarning, message); }
  void error(const std::string& message) { raise(Level::kError, message); }
  /// CPU time that one handler call used [ms].
  void add_handler_ms(std::string_view channel, double cpu_ms);

  [[nodiscard]] std::int64_t counter(std::string_view channel, std::string_view what) const;
  [[nodiscard]] std::map<std::string, std::int64_t> counters() const;
  [[nodiscard]] std::map<std::string, std::vector<double>> handler_ms() const;

  struct Condition {
    Level level = Level::kOk;
    std::string message;
  };
  /// The worst condition since the last call; it starts anew.
  [[nodiscard]] Condition take_condition();
  /// Every distinct warning and error so far, with how often it came, in order of first appearance (at most 100).
  [[nodiscard]] std::vector<std::pair<std::string, std::int64_t>> messages() const;

 private:
  void raise(Level level, const std::string& message);

  mutable std::mutex mutex_;
  std::map<std::string, std::int64_t> counters_;
  std::map<std::string, std::vector<double>> handler_ms_;
  std::vector<std::pair<std::string, std::int64_t>> messages_;
  Condition condition_;
};

}  // namespace arpent
