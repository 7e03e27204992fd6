// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/lcm_bus.h"

#include <lcm/lcm.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <vector>

#include "common/error.h"

namespace arpent {
namespace {

/// LCM's own queue in front of ours: emptied at once, so this only bounds memory if the reader thread is starved.
constexpr int kLcmQueueCapacity = 64;

}  // namespace

struct LcmBus::State {
  struct Subscription {
    State* state;
    std::string channel;
    SubscriptionOptions options;
    RawHandler handler;
    std::deque<std::pair<std::uint64_t, Bytes>> queue;  // guarded by mutex
  };
  struct Timer {
    Duration period;
    std::function<void()> callback;
    std::chrono::steady_clock::time_point next;
  };

  Health* health = nullptr;
  lcm_t* lcm = nullptr;
  std::vector<std::unique_ptr<Subscription>> subscriptions;
  std::vector<Timer> timers;
  std::mutex mutex;
  std::condition_variable arrived;
  std::uint64_t order = 0;
  std::chrono::steady_clock::time_point steady_start = std::chrono::steady_clock::now();
  std::chrono::system_clock::time_point system_start = std::chrono::system_clock::now();
  std::jthread reader;

  static void on_message(const lcm_recv_buf_t* received, const char* /*channel*/, void* user) {
    auto* subscription = static_cast<Subscription*>(user);
    subscription->state->enqueue(*subscription,
                                 BytesView(static_cast<const std::uint8_t*>(received->data), received->data_size));
  }

  void enqueue(Subscription& subscription, BytesView bytes) {
    health->count(subscription.channel, "received");
    if (bytes.size() > subscription.options.max_bytes) {
      health->count(subscription.channel, "undecodable");
      health->warn(subscription.channel + ": message above the channel's size limit dropped");
      return;
    }
    bool dropped = false;
    {
      const std::lock_guard lock(mutex);
      if (static_cast<int>(subscription.queue.size()) >= subscription.options.queue_capacity) {
        subscription.queue.pop_front();
        dropped = true;
      }
      subscription.queue.emplace_back(++order, Bytes(bytes.begin(), bytes.end()));
    }
    if (dropped) {
      health->count(subscription.channel, "dropped");
      health->warn(subscription.channel + ": queue full, oldest message dropped");
    }
    arrived.notify_one();
  }

  /// The subscription whose oldest waiting message came first; nullptr if nothing waits. Needs the mutex.
  Subscription* next() {
    Subscription* first = nullptr;
    for (const auto& subscription : subscriptions) {
      if (subscription->queue.empty()) continue;
      if (first == nullptr || subscription->queue.front().first < first->queue.front().first)
        first = subscription.get();
    }
    return first;
  }

  void run_timers() {
    const auto now = std::chrono::steady_clock::now();
    for (Timer& timer : timers) {
      if (now < timer.next) continue;
      timer.next = std::max(timer.next + timer.period, now);
      timer.callback();
    }
  }

  std::chrono::steady_clock::time_point next_timer(std::chrono::steady_clock::time_point limit) const {
    for (const Timer& timer : timers) limit = std::min(limit, timer.next);
    return limit;
  }
};

LcmBus::LcmBus(const std::string& url) : state_(std::make_unique<State>()) {
  state_->health = &health();
  state_->lcm = lcm_create(url.c_str());
  if (state_->lcm == nullptr) {
    throw InputError("cannot open the bus " + url +
                     ": is there a multicast route? Try `ip route add 224.0.0.0/4 dev lo`, or run `./arpent doctor`");
  }
}

LcmBus::~LcmBus() {
  state_->reader.request_stop();
  if (state_->reader.joinable()) state_->reader.join();
  lcm_destroy(state_->lcm);
}

void LcmBus::publish_bytes(const std::string& channel, BytesView bytes) {
  health().count(channel, "published");
  if (lcm_publish(state_->lcm, channel.c_str(), bytes.data(), static_cast<unsigned>(bytes.size())) != 0) {
    health().count(channel, "unsent");
    health().warn(channel + ": the bus refused a message");
  }
}

void LcmBus::subscribe_bytes(const std::string& channel, const SubscriptionOptions& options, RawHandler handler) {
  ARPENT_ASSERT(!state_->reader.joinable());
  auto subscription = std::make_unique<State::Subscription>();
  subscription->state = state_.get();
  subscription->channel = channel;
  subscription->options = options;
  subscription->handler = std::move(handler);
  lcm_subscription_t* handle = lcm_subscribe(state_->lcm, channel.c_str(), &State::on_message, subscription.get());
  ARPENT_ASSERT(handle != nullptr);
  lcm_subscription_set_queue_capacity(handle, kLcmQueueCapacity);
  state_->subscriptions.push_back(std::move(subscription));
}

Time LcmBus::now() const {
  const auto elapsed = std::chrono::steady_clock::now() - state_->steady_start;
  return Time(std::chrono::duration_cast<Duration>(state_->system_start.time_since_epoch() + elapsed));
}

void LcmBus::every(Duration period, std::function<void()> callback) {
  state_->timers.push_back({period, std::move(callback), std::chrono::steady_clock::now() + period});
}

void LcmBus::start() {
  state_->reader = std::jthread([state = state_.get()](const std::stop_token& stop) {
    while (!stop.stop_requested()) lcm_handle_timeout(state->lcm, 50);
  });
}

void LcmBus::run_for(Duration duration) {
  const auto until = std::chrono::steady_clock::now() + duration;
  do {
    state_->run_timers();
    Bytes bytes;
    State::Subscription* subscription = nullptr;
    {
      std::unique_lock lock(state_->mutex);
      state_->arrived.wait_until(lock, state_->next_timer(until), [&] { return state_->next() != nullptr; });
      subscription = state_->next();
      if (subscription != nullptr) {
        bytes = std::move(subscription->queue.front().second);
        subscription->queue.pop_front();
      }
    }
    if (subscription != nullptr) {
      subscription->handler(bytes);
      return;
    }
  } while (std::chrono::steady_clock::now() < until);
}

}  // namespace arpent
