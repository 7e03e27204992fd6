// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/health.h"

#include <algorithm>

namespace arpent {
namespace {

constexpr std::size_t kMaxMessages = 100;
constexpr std::size_t kMaxTimings = 100000;

std::string key(std::string_view channel, std::string_view what) {
  return std::string(channel) + '.' + std::string(what);
}

}  // namespace

void Health::count(std::string_view channel, std::string_view what, std::int64_t increment) {
  const std::lock_guard lock(mutex_);
  counters_[key(channel, what)] += increment;
}

void Health::add_handler_ms(std::string_view channel, double cpu_ms) {
  const std::lock_guard lock(mutex_);
  std::vector<double>& timings = handler_ms_[std::string(channel)];
  if (timings.size() < kMaxTimings) timings.push_back(cpu_ms);
}

std::int64_t Health::counter(std::string_view channel, std::string_view what) const {
  const std::lock_guard lock(mutex_);
  const auto found = counters_.find(key(channel, what));
  return found == counters_.end() ? 0 : found->second;
}

std::map<std::string, std::int64_t> Health::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

std::map<std::string, std::vector<double>> Health::handler_ms() const {
  const std::lock_guard lock(mutex_);
  return handler_ms_;
}

Health::Condition Health::take_condition() {
  const std::lock_guard lock(mutex_);
  Condition taken = condition_;
  condition_ = {};
  return taken;
}

std::vector<std::pair<std::string, std::int64_t>> Health::messages() const {
  const std::lock_guard lock(mutex_);
  return messages_;
}

void Health::raise(Level level, const std::string& message) {
  const std::lock_guard lock(mutex_);
  if (level >= condition_.level) condition_ = {level, message};
  const auto same = std::find_if(messages_.begin(), messages_.end(), [&](const auto& m) { return m.first == message; });
  if (same != messages_.end()) {
    ++same->second;
  } else if (messages_.size() < kMaxMessages) {
    messages_.emplace_back(message, 1);
  }
}

}  // namespace arpent
