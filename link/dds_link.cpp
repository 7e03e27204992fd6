// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/dds_link.h"

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>

#include "common/error.h"
#include "link/dds_entities.h"
#include "link/dds_settings.h"
#include "link/dds_types.h"
#include "link/pacer.h"

namespace arpent::link {
namespace {

using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

constexpr auto kRetry = 2s;
constexpr auto kTurn = 100ms;  ///< so often the threads look whether they shall end
constexpr std::size_t kMaxWaitingBytes = std::size_t{32} << 20;
constexpr std::size_t kTaken = 16;  ///< samples at once
/// A history of thousands of pieces comes to a station that starts late: no faster than its bus and its map can take it
/// (16 pieces in 20 ms are 6 MB/s). DDS keeps the rest meanwhile.
constexpr auto kBulkBreath = 20ms;

Time steady_now() {
  return Time(std::chrono::duration_cast<Duration>(Steady::now().time_since_epoch()));
}

/// Hands every valid sample that the reader has (at most kTaken) to `handle`. Whether there were that many.
template <class Sample, class Handle>
bool take(dds_entity_t reader, Handle handle) {
  void* samples[kTaken] = {};
  dds_sample_info_t infos[kTaken];
  const dds_return_t count = dds_take(reader, samples, infos, kTaken, kTaken);
  if (count <= 0) return false;
  for (dds_return_t i = 0; i < count; ++i) {
    if (infos[i].valid_data) handle(*static_cast<const Sample*>(samples[i]));
  }
  dds_return_loan(reader, samples, count);
  return count == static_cast<dds_return_t>(kTaken);
}

void wait_for(dds_entity_t waitset) {
  dds_waitset_wait(waitset, nullptr, 0, DDS_MSECS(std::chrono::milliseconds(kTurn).count()));
}

/// Cyclone's own warnings: one a second, because in an outage there is one for each packet.
struct Complaints {
  const LinkEvents& events;
  Steady::time_point next{};
  std::mutex mutex;

  static void sink(void* self, const dds_log_data_t* data) {
    if ((data->priority & (DDS_LC_ERROR | DDS_LC_WARNING | DDS_LC_FATAL)) == 0) return;
    static_cast<Complaints*>(self)->pass(std::string(data->message, data->size));
  }
  void pass(std::string text) {
    const std::lock_guard lock(mutex);
    if (Steady::now() < next) return;
    next = Steady::now() + 1s;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    events.warn("DDS: " + text);
  }
};

}  // namespace

struct DdsLink::State {
  LinkParams params;
  LinkEvents events;
  Complaints complaints{events, {}, {}};
  std::unique_ptr<Entities> entities;  // set once, before `connected`
  std::atomic<bool> connected = false;
  std::mutex mutex;
  std::condition_variable_any changed;
  std::deque<Part> waiting;  // guarded by mutex
  std::size_t waiting_bytes = 0;
  std::jthread receiver, bulk_receiver, sender;

  /// Or until the end.
  void sleep_until(const std::stop_token& stop, Time at) {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, stop, at - steady_now(), [] { return false; });
  }

  void connect(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      try {
        entities = std::make_unique<Entities>(params);
        {
          const std::lock_guard lock(mutex);
          connected = true;
        }
        changed.notify_all();
        return;
      } catch (const InputError& error) {
        events.warn(std::string(error.what()) + "; trying again");
      }
      sleep_until(stop, steady_now() + kRetry);
    }
  }

  void receive(const std::stop_token& stop) {
    connect(stop);
    while (!stop.stop_requested()) {
      wait_for(entities->control_waitset);
      take<arpent_link_BeatSample>(entities->beats.reader, [this](const auto& s) { events.beat(to_beat(s)); });
      take<arpent_link_CommandSample>(entities->commands.reader,
                                      [this](const auto& s) { events.command(to_command(s)); });
    }
  }

  void receive_bulk(const std::stop_token& stop) {
    {
      std::unique_lock lock(mutex);
      changed.wait(lock, stop, [&] { return connected.load(); });
    }
    while (!stop.stop_requested()) {
      wait_for(entities->bulk_waitset);
      const bool more =
          take<arpent_link_PartSample>(entities->parts.reader, [this](const auto& s) { events.part(to_part(s)); });
      if (more) std::this_thread::sleep_for(kBulkBreath);
    }
  }

  /// The next part and when it may go; false at the end.
  bool next(const std::stop_token& stop, Part& part) {
    std::unique_lock lock(mutex);
    changed.wait(lock, stop, [&] { return connected && !waiting.empty(); });
    if (stop.stop_requested()) return false;
    part = std::move(waiting.front());
    waiting.pop_front();
    waiting_bytes -= part.data.size();
    return true;
  }

  void send(const std::stop_token& stop) {
    Pacer pacer(params.bulk_rate_mbps);
    for (Part part; next(stop, part);) {
      sleep_until(stop, pacer.next(steady_now(), part.data.size()));
      const BorrowedPart borrowed(part);
      // Refused while too much is unacknowledged: the piece waits, and those behind it.
      while (!stop.stop_requested() && dds_write(entities->parts.writer, &borrowed.sample) == DDS_RETCODE_TIMEOUT) {
        events.warn("patches wait: too much is on its way to stations that do not answer");
        std::this_thread::sleep_for(kTurn);
      }
    }
  }
};

DdsLink::DdsLink(const LinkParams& params, LinkEvents events) : state_(std::make_unique<State>()) {
  (void)security_properties(params);  // missing keys are found now
  state_->params = params;
  state_->events = std::move(events);
  dds_set_log_sink(&Complaints::sink, &state_->complaints);
  dds_set_trace_sink(&Complaints::sink, &state_->complaints);
  state_->receiver = std::jthread([state = state_.get()](const std::stop_token& stop) { state->receive(stop); });
  state_->bulk_receiver =
      std::jthread([state = state_.get()](const std::stop_token& stop) { state->receive_bulk(stop); });
  state_->sender = std::jthread([state = state_.get()](const std::stop_token& stop) { state->send(stop); });
}

DdsLink::~DdsLink() {
  for (std::jthread* thread : {&state_->receiver, &state_->bulk_receiver, &state_->sender}) thread->request_stop();
  for (std::jthread* thread : {&state_->receiver, &state_->bulk_receiver, &state_->sender}) thread->join();
  state_->entities.reset();
  dds_set_log_sink(nullptr, nullptr);
  dds_set_trace_sink(nullptr, nullptr);
}

bool DdsLink::connected() const {
  return state_->connected;
}

bool DdsLink::write(const Beat& beat) {
  if (!connected()) return false;
  const BorrowedBeat borrowed(beat);
  return dds_write(state_->entities->beats.writer, &borrowed.sample) == DDS_RETCODE_OK;
}

bool DdsLink::write(const Command& command) {
  if (!connected()) return false;
  const BorrowedCommand borrowed(command);
  return dds_write(state_->entities->commands.writer, &borrowed.sample) == DDS_RETCODE_OK;
}

bool DdsLink::queue(std::vector<Part> parts) {
  {
    const std::lock_guard lock(state_->mutex);
    std::size_t bytes = 0;
    for (const Part& part : parts) bytes += part.data.size();
    if (state_->waiting_bytes + bytes > kMaxWaitingBytes) return false;
    state_->waiting_bytes += bytes;
    for (Part& part : parts) state_->waiting.push_back(std::move(part));
  }
  state_->changed.notify_all();
  return true;
}

}  // namespace arpent::link
