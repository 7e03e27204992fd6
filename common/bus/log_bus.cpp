// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/log_bus.h"

#include <algorithm>

#include "common/error.h"

namespace arpent {

LogBus::LogBus(const std::filesystem::path& in, const std::filesystem::path& out) : reader_(in) {
  if (!out.empty()) writer_ = std::make_unique<LogWriter>(out);
  if (const auto first = reader_.next()) now_ = first->time;
  reader_.rewind();
}

void LogBus::publish_bytes(const std::string& channel, BytesView bytes) {
  health().count(channel, "published");
  if (writer_ && !writer_->write(now_, channel, bytes)) health().count(channel, "unsent");
}

void LogBus::subscribe_bytes(const std::string& channel, const SubscriptionOptions& options, RawHandler handler) {
  subscriptions_.push_back({channel, options, std::move(handler)});
}

void LogBus::every(Duration period, std::function<void()> callback) {
  ARPENT_ASSERT(period > Duration(0));
  timers_.push_back({period, std::move(callback), now_ + period});
}

void LogBus::ring_until(Time time) {
  for (;;) {
    const auto due = std::min_element(timers_.begin(), timers_.end(),
                                      [](const Timer& a, const Timer& b) { return a.next < b.next; });
    if (due == timers_.end() || due->next > time) return;
    now_ = due->next;
    due->next += due->period;
    due->callback();
  }
}

void LogBus::run() {
  while (const auto event = reader_.next()) {
    ring_until(event->time);
    now_ = std::max(now_, event->time);
    for (const Subscription& subscription : subscriptions_) {
      if (subscription.channel != event->channel) continue;
      health().count(event->channel, "received");
      if (event->data.size() > subscription.options.max_bytes) {
        health().count(event->channel, "undecodable");
      } else {
        subscription.handler(event->data);
      }
    }
  }
  if (writer_) writer_->close();
}

}  // namespace arpent
