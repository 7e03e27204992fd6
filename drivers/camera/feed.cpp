// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/feed.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

namespace arpent::camera {
namespace {

using Steady = std::chrono::steady_clock;

constexpr Duration kWait{20000};
constexpr std::size_t kMostWaiting = 32;
constexpr std::chrono::milliseconds kPatience{500};

}  // namespace

struct ThreadedFeed::State {
  OpenSource open;
  FeedParams params;
  mutable std::mutex mutex;
  std::condition_variable changed;
  bool stop = false;      // all below guarded by mutex
  bool finished = false;  // the thread touches nothing any more
  std::vector<Frame> frames;
  std::optional<ExposureSetting> wanted;   // asked for and not yet written
  std::optional<ExposureSetting> current;  // asked for last: a device that comes back gets it again
  FeedCondition condition;

  void run() {
    Duration wait = from_seconds(params.retry_first_s);
    while (!stopped()) {
      const bool delivered = keep_open();
      if (delivered) wait = from_seconds(params.retry_first_s);
      std::unique_lock lock(mutex);
      changed.wait_for(lock, wait, [this] { return stop; });
      wait = std::min(2 * wait, from_seconds(params.retry_most_s));
    }
    const std::lock_guard lock(mutex);
    finished = true;
    changed.notify_all();
  }

  [[nodiscard]] bool stopped() const {
    const std::lock_guard lock(mutex);
    return stop;
  }

  void report(bool is_open, const std::string& fault) {
    const std::lock_guard lock(mutex);
    condition.open = is_open;
    condition.fault = fault;
  }

  /// Opens the device and reads it until it is lost. True if frames came.
  bool keep_open() {
    bool delivered = false;
    try {
      const std::unique_ptr<FrameSource> source = open();
      {
        const std::lock_guard lock(mutex);
        ++condition.openings;
        wanted = current;
      }
      report(true, "");
      read(*source, delivered);
    } catch (const std::exception& error) {
      report(false, error.what());
    }
    return delivered;
  }

  void read(FrameSource& source, bool& delivered) {
    const auto silence = std::chrono::duration<double>(params.silence_s);
    auto heard = Steady::now();
    std::int64_t incomplete_before = 0;
    while (!stopped()) {
      write_exposure(source);
      auto frame = source.next(kWait);
      const std::int64_t incomplete = source.incomplete();
      if (frame) {
        deliver(std::move(*frame), incomplete - incomplete_before);
        incomplete_before = incomplete;
        delivered = true;
        heard = Steady::now();
      } else if (Steady::now() - heard > silence) {
        if (!source.answers()) throw DeviceLost("it does not answer any more: unplugged or without power");
        report(true, "it answers but sends no images: is it triggered?");
        heard = Steady::now();
      }
    }
  }

  void write_exposure(FrameSource& source) {
    std::optional<ExposureSetting> setting;
    {
      const std::lock_guard lock(mutex);
      setting = std::exchange(wanted, std::nullopt);
    }
    if (setting) source.set_exposure(*setting);
  }

  void deliver(Frame frame, std::int64_t incomplete) {
    const std::lock_guard lock(mutex);
    condition.fault.clear();
    condition.incomplete += incomplete;
    frame.session = condition.openings;
    if (frames.size() >= kMostWaiting) {
      frames.erase(frames.begin());
      ++condition.dropped;
    }
    frames.push_back(std::move(frame));
  }
};

ThreadedFeed::ThreadedFeed(OpenSource open, const FeedParams& params) : state_(std::make_shared<State>()) {
  state_->open = std::move(open);
  state_->params = params;
  std::thread([state = state_] { state->run(); }).detach();
}

ThreadedFeed::~ThreadedFeed() {
  std::unique_lock lock(state_->mutex);
  state_->stop = true;
  state_->changed.notify_all();
  state_->changed.wait_for(lock, kPatience, [this] { return state_->finished; });
}

std::vector<Frame> ThreadedFeed::take() {
  const std::lock_guard lock(state_->mutex);
  return std::exchange(state_->frames, {});
}

void ThreadedFeed::set_exposure(const ExposureSetting& setting) {
  const std::lock_guard lock(state_->mutex);
  state_->wanted = setting;
  state_->current = setting;
}

FeedCondition ThreadedFeed::condition() const {
  const std::lock_guard lock(state_->mutex);
  return state_->condition;
}

std::vector<Frame> DirectFeed::take() {
  std::vector<Frame> frames;
  while (auto frame = source_->next(Duration(0))) frames.push_back(std::move(*frame));
  return frames;
}

}  // namespace arpent::camera
