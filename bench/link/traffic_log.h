// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What stations sent and got in a bench of the radio link, with times of one clock, and the figures made of it.
// Messages are patterns that tell their sender and number and are checked byte by byte.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace arpent::bench {

/// Number and sender in front, then bytes that follow from them.
[[nodiscard]] std::vector<std::uint8_t> make_pattern(int sender, std::uint32_t number, std::size_t size);
/// Sender and number; nullopt if a byte is not as it was made.
[[nodiscard]] std::optional<std::pair<int, std::uint32_t>> read_pattern(std::span<const std::uint8_t> bytes);

/// One kind of message between `stations`, each to all others.
class TrafficLog {
 public:
  explicit TrafficLog(int stations) : stations_(stations) {}

  /// The pattern to send now.
  [[nodiscard]] std::vector<std::uint8_t> send(int sender, double now_s, std::size_t size);
  /// The first time that it arrives counts.
  void receive(int receiver, double now_s, std::span<const std::uint8_t> bytes);

  [[nodiscard]] std::int64_t bad() const;
  /// Deliveries within `limit_s`, of the messages sent in [from_s, to_s), over those wanted [%]. `station` >= 0: only
  /// from and to this one.
  [[nodiscard]] double delivered_percent(double limit_s, double from_s, double to_s, int station = -1) const;
  /// Age of the newest message, looked at every 10 ms in [from_s, to_s) on every pair: its `share` quantile [s].
  [[nodiscard]] double age_s(double share, double from_s, double to_s) const;
  /// Until a message sent after `heal_s` had arrived on the slowest pair with `station` [s]; 1e9 if one got none.
  [[nodiscard]] double recovery_s(double heal_s, int station) const;
  /// Whether every pair has got something sent after `since_s`.
  [[nodiscard]] bool all_pairs(double since_s) const;

 private:
  using Arrivals = std::vector<std::pair<double, std::uint32_t>>;
  template <class Visit>
  void visit_pairs(int station, Visit visit) const;

  int stations_;
  mutable std::mutex mutex_;
  std::map<int, std::vector<double>> sent_s_;                                ///< by sender, by number
  std::map<std::pair<int, int>, std::map<std::uint32_t, double>> received_;  ///< (receiver, sender): number -> time
  std::int64_t bad_ = 0;
};

}  // namespace arpent::bench
