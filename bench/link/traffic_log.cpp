// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/link/traffic_log.h"

#include <algorithm>

namespace arpent::bench {
namespace {

constexpr std::size_t kHeader = 5;
constexpr double kNever = 1e9;

std::uint8_t filler(int sender, std::uint32_t number, std::size_t i) {
  return static_cast<std::uint8_t>((i * 31 + number * 7 + static_cast<std::size_t>(sender) * 101) >> 1);
}

}  // namespace

std::vector<std::uint8_t> make_pattern(int sender, std::uint32_t number, std::size_t size) {
  std::vector<std::uint8_t> bytes(size);
  bytes[0] = static_cast<std::uint8_t>(sender);
  for (std::size_t i = 1; i < kHeader; ++i) bytes[i] = static_cast<std::uint8_t>(number >> (8 * (i - 1)));
  for (std::size_t i = kHeader; i < size; ++i) bytes[i] = filler(sender, number, i);
  return bytes;
}

std::optional<std::pair<int, std::uint32_t>> read_pattern(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < kHeader) return {};
  std::uint32_t number = 0;
  for (std::size_t i = 1; i < kHeader; ++i) number |= static_cast<std::uint32_t>(bytes[i]) << (8 * (i - 1));
  for (std::size_t i = kHeader; i < bytes.size(); ++i) {
    if (bytes[i] != filler(bytes[0], number, i)) return {};
  }
  return std::pair(int{bytes[0]}, number);
}

std::vector<std::uint8_t> TrafficLog::send(int sender, double now_s, std::size_t size) {
  const std::lock_guard lock(mutex_);
  std::vector<double>& sent = sent_s_[sender];
  sent.push_back(now_s);
  return make_pattern(sender, static_cast<std::uint32_t>(sent.size() - 1), size);
}

void TrafficLog::receive(int receiver, double now_s, std::span<const std::uint8_t> bytes) {
  const auto read = read_pattern(bytes);
  const std::lock_guard lock(mutex_);
  if (!read || read->second >= sent_s_[read->first].size()) {
    ++bad_;
    return;
  }
  received_[{receiver, read->first}].try_emplace(read->second, now_s);
}

std::int64_t TrafficLog::bad() const {
  const std::lock_guard lock(mutex_);
  return bad_;
}

/// `visit(sent times, number -> arrival)` for each pair; `station` >= 0: those with it.
template <class Visit>
void TrafficLog::visit_pairs(int station, Visit visit) const {
  static const std::map<std::uint32_t, double> kNothing;
  const std::lock_guard lock(mutex_);
  for (const auto& [sender, sent] : sent_s_) {
    for (int receiver = 0; receiver < stations_; ++receiver) {
      if (receiver == sender || (station >= 0 && station != sender && station != receiver)) continue;
      const auto found = received_.find({receiver, sender});
      visit(sent, found == received_.end() ? kNothing : found->second);
    }
  }
}

double TrafficLog::delivered_percent(double limit_s, double from_s, double to_s, int station) const {
  std::int64_t wanted = 0, delivered = 0;
  visit_pairs(station, [&](const std::vector<double>& sent, const auto& received) {
    for (std::uint32_t n = 0; n < sent.size(); ++n) {
      if (sent[n] < from_s || sent[n] >= to_s) continue;
      ++wanted;
      const auto found = received.find(n);
      if (found != received.end() && found->second - sent[n] <= limit_s) ++delivered;
    }
  });
  return wanted == 0 ? 0 : 100.0 * static_cast<double>(delivered) / static_cast<double>(wanted);
}

double TrafficLog::age_s(double share, double from_s, double to_s) const {
  constexpr double kStep = 0.01;
  std::vector<double> ages;
  visit_pairs(-1, [&](const std::vector<double>& sent, const auto& received) {
    std::vector<std::pair<double, double>> arrivals;  // when, and when it was sent
    for (const auto& [number, at] : received) arrivals.emplace_back(at, sent[number]);
    std::sort(arrivals.begin(), arrivals.end());
    double newest = -kNever;
    auto next = arrivals.begin();
    for (double t = from_s; t < to_s; t += kStep) {
      for (; next != arrivals.end() && next->first <= t; ++next) newest = std::max(newest, next->second);
      ages.push_back(t - newest);
    }
  });
  if (ages.empty()) return kNever;
  const auto nth = ages.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(ages.size() - 1));
  std::nth_element(ages.begin(), nth, ages.end());
  return *nth;
}

double TrafficLog::recovery_s(double heal_s, int station) const {
  double slowest = 0;
  visit_pairs(station, [&](const std::vector<double>& sent, const auto& received) {
    double first = kNever;
    for (const auto& [number, at] : received) {
      if (sent[number] >= heal_s) first = std::min(first, at - heal_s);
    }
    slowest = std::max(slowest, first);
  });
  return slowest;
}

bool TrafficLog::all_pairs(double since_s) const {
  bool all = true;
  int pairs = 0;
  visit_pairs(-1, [&](const std::vector<double>& sent, const auto& received) {
    ++pairs;
    const auto newest = received.rbegin();
    all = all && newest != received.rend() && sent[newest->first] >= since_s;
  });
  return all && pairs == stations_ * (stations_ - 1);
}

}  // namespace arpent::bench
