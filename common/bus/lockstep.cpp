// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/lockstep.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <utility>

#include "common/error.h"

namespace arpent {

/// Something that happens at a time. A message has bytes; a timer has a process and an index; a wake-up (the end of a
/// process' busy time) has neither.
struct LockstepExecutor::Event {
  Time time;
  std::uint64_t order = 0;
  std::string channel;
  std::shared_ptr<const Bytes> bytes;
  ProcessBus* process = nullptr;
  std::size_t timer = 0;

  [[nodiscard]] bool is_message() const { return bytes != nullptr; }
  [[nodiscard]] bool is_timer() const { return process != nullptr; }
};

bool LockstepExecutor::Later::operator()(const Event& a, const Event& b) const {
  return a.time != b.time ? a.time > b.time : a.order > b.order;
}

/// One process: its subscriptions, what waits for it, and what its running handler publishes.
class LockstepExecutor::ProcessBus : public Bus, public Clock {
 public:
  ProcessBus(LockstepExecutor& executor, std::string name, std::string prefix)
      : executor_(executor), name_(std::move(name)), prefix_(std::move(prefix)) {}

  void publish_bytes(const std::string& channel, BytesView bytes) override {
    health().count(channel, "published");
    outputs_.push_back({full(channel), std::make_shared<const Bytes>(bytes.begin(), bytes.end())});
  }

  void subscribe_bytes(const std::string& channel, const SubscriptionOptions& options, RawHandler handler) override {
    subscriptions_.push_back({channel, full(channel), options, std::move(handler), {}});
  }

  [[nodiscard]] Time now() const override { return executor_.now(); }

  void every(Duration period, std::function<void()> callback) override {
    ARPENT_ASSERT(period > Duration(0));
    timers_.push_back({period, std::move(callback), false});
    schedule_timer(timers_.size() - 1);
  }

  void receive(const Event& event) {
    if (silent_) return;
    for (Subscription& subscription : subscriptions_) {
      if (subscription.full_channel == event.channel) enqueue(subscription, event);
    }
  }

  void ring(std::size_t timer) {
    if (silent_) return;
    timers_[timer].due = true;
    schedule_timer(timer);
  }

  void silence(const std::string& prefix, const std::string& spared) {
    if (prefix_ != prefix || name_ == spared) return;
    silent_ = true;
    for (Subscription& subscription : subscriptions_) subscription.queue.clear();
    for (Timer& timer : timers_) timer.due = false;
  }

  [[nodiscard]] bool due(Time time) const { return busy_until_ <= time && next() != Next::kNothing; }
  [[nodiscard]] bool has_waiting() const { return next() == Next::kMessage; }

  /// Runs one handler or the timers that are due; outputs wait for commit().
  void run_one() {
    latency_ = Duration(0);
    if (next() == Next::kTimer) {
      for (std::size_t i = 0; i < timers_.size(); ++i) {
        if (std::exchange(timers_[i].due, false)) timers_[i].callback();
      }
      return;
    }
    Subscription* first = nullptr;
    for (Subscription& subscription : subscriptions_) {
      if (subscription.queue.empty()) continue;
      if (first == nullptr || subscription.queue.front().order < first->queue.front().order) first = &subscription;
    }
    const Waiting waiting = std::move(first->queue.front());
    first->queue.pop_front();
    latency_ = first->options.latency;
    first->handler(*waiting.bytes);
  }

  /// A handler that publishes nothing (a pair passed over by the rate, say) takes no time: its latency is that of its
  /// outputs.
  void commit() {
    if (outputs_.empty()) latency_ = Duration(0);
    for (auto& [channel, bytes] : outputs_) {
      executor_.push({executor_.now() + latency_, 0, channel, bytes, nullptr, 0});
    }
    outputs_.clear();
    busy_until_ = executor_.now() + latency_;
    if (latency_ > Duration(0)) executor_.push({busy_until_, 0, "", nullptr, nullptr, 0});
  }

 private:
  struct Waiting {
    std::uint64_t order;
    std::shared_ptr<const Bytes> bytes;
  };
  struct Subscription {
    std::string channel;
    std::string full_channel;
    SubscriptionOptions options;
    RawHandler handler;
    std::deque<Waiting> queue;
  };
  struct Timer {
    Duration period;
    std::function<void()> callback;
    bool due;
  };
  enum class Next { kNothing, kTimer, kMessage };

  [[nodiscard]] std::string full(const std::string& channel) const {
    return channel.find('/') == std::string::npos ? prefix_ + channel : channel;
  }

  void enqueue(Subscription& subscription, const Event& event) {
    health().count(subscription.channel, "received");
    if (event.bytes->size() > subscription.options.max_bytes) {
      health().count(subscription.channel, "undecodable");
      health().warn(subscription.channel + ": message above the channel's size limit dropped");
      return;
    }
    if (static_cast<int>(subscription.queue.size()) >= subscription.options.queue_capacity) {
      subscription.queue.pop_front();
      health().count(subscription.channel, "dropped");
      health().warn(subscription.channel + ": queue full, oldest message dropped");
    }
    subscription.queue.push_back({event.order, event.bytes});
  }

  void schedule_timer(std::size_t timer) {
    executor_.push({executor_.now() + timers_[timer].period, 0, "", nullptr, this, timer});
  }

  [[nodiscard]] Next next() const {
    for (const Timer& timer : timers_) {
      if (timer.due) return Next::kTimer;
    }
    for (const Subscription& subscription : subscriptions_) {
      if (!subscription.queue.empty()) return Next::kMessage;
    }
    return Next::kNothing;
  }

  LockstepExecutor& executor_;
  std::string name_, prefix_;
  bool silent_ = false;
  std::vector<Subscription> subscriptions_;
  std::vector<Timer> timers_;
  Time busy_until_{};
  Duration latency_{0};
  std::vector<std::pair<std::string, std::shared_ptr<const Bytes>>> outputs_;
};

LockstepExecutor::LockstepExecutor(Time start, int threads) : now_(start), threads_(std::max(1, threads)) {}
LockstepExecutor::~LockstepExecutor() = default;

LockstepExecutor::Endpoint LockstepExecutor::add_process(const std::string& name, const std::string& prefix) {
  processes_.push_back(std::make_unique<ProcessBus>(*this, name, prefix));
  return {*processes_.back(), *processes_.back()};
}

void LockstepExecutor::inject(Time time, const std::string& channel, BytesView bytes) {
  push({std::max(time, now_), 0, channel, std::make_shared<const Bytes>(bytes.begin(), bytes.end()), nullptr, 0});
}

void LockstepExecutor::silence(const std::string& prefix, const std::string& spared) {
  for (const auto& process : processes_) process->silence(prefix, spared);
}

void LockstepExecutor::push(Event event) {
  event.order = ++order_;
  if (!event.is_timer()) ++pending_messages_;
  heap_.push_back(std::move(event));
  std::push_heap(heap_.begin(), heap_.end(), Later{});
}

void LockstepExecutor::deliver(const Event& event) {
  if (event.is_timer()) {
    event.process->ring(event.timer);
    return;
  }
  --pending_messages_;
  if (!event.is_message()) return;
  if (tap_) tap_(event.time, event.channel, *event.bytes);
  for (const auto& process : processes_) process->receive(event);
}

void LockstepExecutor::step() {
  now_ = std::max(now_, heap_.front().time);
  while (!heap_.empty() && heap_.front().time <= now_) {
    std::pop_heap(heap_.begin(), heap_.end(), Later{});
    const Event event = std::move(heap_.back());
    heap_.pop_back();
    deliver(event);
  }
  run_due();
}

void LockstepExecutor::run_due() {
  for (;;) {
    std::vector<ProcessBus*> due;
    for (const auto& process : processes_) {
      if (process->due(now_)) due.push_back(process.get());
    }
    if (due.empty()) return;
    std::atomic<std::size_t> taken{0};
    const auto work = [&] {
      for (std::size_t i = taken++; i < due.size(); i = taken++) due[i]->run_one();
    };
    {
      std::vector<std::jthread> helpers;
      const std::size_t wanted = std::min<std::size_t>(static_cast<std::size_t>(threads_), due.size());
      for (std::size_t i = 1; i < wanted; ++i) helpers.emplace_back(work);
      work();
    }
    for (ProcessBus* process : due) process->commit();
  }
}

void LockstepExecutor::run_until(Time time) {
  run_due();
  while (!heap_.empty() && heap_.front().time <= time) step();
  now_ = std::max(now_, time);
}

bool LockstepExecutor::waiting_or_messages() const {
  return pending_messages_ > 0 ||
         std::any_of(processes_.begin(), processes_.end(), [](const auto& process) { return process->has_waiting(); });
}

void LockstepExecutor::run_until_idle() {
  run_due();
  while (waiting_or_messages() && !heap_.empty()) step();
}

}  // namespace arpent
