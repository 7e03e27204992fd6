// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/process/team_link_process.h"

#include <arpent/base_request_t.hpp>
#include <mutex>
#include <random>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "link/dds_link.h"
#include "link/sent_history.h"
#include "link/station.h"

namespace arpent {
namespace {

using link::Channel;

/// A larger message does not fit into the pieces of a patch.
constexpr std::size_t kMaxPatchBytes = link::kMaxParts * link::kPartBytes;
/// States and commands travel in one sample.
constexpr std::size_t kMaxMessageBytes = 60000;

/// As what a station of this role publishes what it receives; nullptr: not at all.
const char* received_as(Channel channel, bool robot) {
  switch (channel) {
    case Channel::kState:
      return channels::kTeamState;
    case Channel::kPatch:
      return channels::kTeamPatch;
    case Channel::kTour:
      return robot ? channels::kTeamTour : nullptr;
    case Channel::kReport:
      return robot ? nullptr : channels::kTeamReport;
    case Channel::kStop:
      return channels::kEstop;
    case Channel::kBeat:
      return nullptr;
  }
  return nullptr;
}

}  // namespace

struct TeamLinkProcess::State {
  Config config;
  Bus& bus;
  Clock& clock;
  std::mutex mutex;       ///< of the station: the bus' thread and the link's meet in it
  link::Station station;  // guarded by mutex
  Time last_beat{};
  link::SentHistory history;
  bool connected = false;
  Time apart_at{};  ///< the last time that somebody was missed
  std::unique_ptr<link::DdsLink> dds;

  State(const Config& c, Bus& process_bus, Clock& process_clock)
      : config(c),
        bus(process_bus),
        clock(process_clock),
        station(c.station, std::random_device{}()),
        history(c.link.patch_history) {}

  void connect() {
    connected = false;
    dds = std::make_unique<link::DdsLink>(
        config.link, link::LinkEvents{[this](const link::Beat& m) { receive("radio_beat", m); },
                                      [this](const link::Command& m) { receive("radio_command", m); },
                                      [this](const link::Part& m) { receive("radio_patch", m); },
                                      [this](const std::string& text) { bus.health().warn(text); }});
  }

  /// Nobody has been missed for long enough that commands reach everybody.
  [[nodiscard]] bool together() const { return clock.now() - apart_at > std::chrono::seconds(1); }

  void look_after_connection() {
    const Time now = clock.now();
    bool stuck = false;
    {
      const std::lock_guard lock(mutex);
      if (!connected && dds->connected()) station.connected(now);
      stuck = connected && station.should_reconnect(now);
      if (!connected || station.misses_somebody(now)) apart_at = now;
    }
    connected = dds->connected();
    if (together()) {
      for (const link::Command& command : history.take_commands()) dds->write(command);
    }
    if (stuck) reconnect();
  }

  void reconnect() {
    bus.health().count("radio", "reconnected");
    dds.reset();
    connect();
    dds->queue(history.parts());
  }

  [[nodiscard]] bool robot() const { return config.role == "robot"; }

  void count_sent(const char* channel, std::size_t bytes, bool sent) {
    bus.health().count(channel, sent ? "radio_sent" : "radio_unsent");
    if (sent) bus.health().count(channel, "radio_bytes_sent", static_cast<std::int64_t>(bytes));
  }

  void send_beat(bool only_if_due) {
    const Time now = clock.now();
    link::Beat beat;
    {
      const std::lock_guard lock(mutex);
      // A state that went out just now was a beat too; a stop is repeated at its full rate.
      if (only_if_due && !station.stopped() && now - last_beat < from_seconds(0.5 / config.beat_hz)) return;
      beat = station.beat(now);
      last_beat = now;
    }
    dds->write(beat);
  }

  void send_state(BytesView bytes) {
    link::Beat beat;
    {
      const std::lock_guard lock(mutex);
      beat = station.state(clock.now(), bytes);
      last_beat = beat.clock;
    }
    count_sent(channels::kRobotState, bytes.size(), dds->write(beat));
  }

  void send_command(const char* name, Channel channel, BytesView bytes) {
    link::Command command;
    {
      const std::lock_guard lock(mutex);
      command = station.command(channel, bytes);
    }
    // A tour is soon too late, and the next one comes; a report is a fact.
    if (channel == Channel::kReport && !together()) history.add(command);
    count_sent(name, bytes.size(), dds->write(command));
  }

  void send_patch(BytesView bytes) {
    std::vector<link::Part> parts;
    {
      const std::lock_guard lock(mutex);
      parts = station.parts(bytes);
    }
    history.add(parts);
    count_sent(channels::kMapPatch, bytes.size(), dds->queue(std::move(parts)));
  }

  void send_stop(BytesView bytes) {
    std::optional<link::Command> event;
    {
      const std::lock_guard lock(mutex);
      event = station.stop(bytes);
    }
    if (!event) return;
    send_beat(false);
    count_sent(channels::kEstop, bytes.size(), dds->write(*event));
  }

  void on_request(const base_request_t& request) {
    if (request.action != base_request_t::ACTION_RELEASE) return;
    const std::lock_guard lock(mutex);
    station.release();
  }

  /// From the link's thread.
  template <class Message>
  void receive(const char* envelope, const Message& message) {
    link::Taken taken;
    {
      const std::lock_guard lock(mutex);
      if constexpr (requires { station.take(clock.now(), message); }) {
        taken = station.take(clock.now(), message);
      } else {
        taken = station.take(message);
      }
    }
    if (!taken.refused.empty()) bus.health().count(envelope, taken.refused);
    if (taken.refused == "namesake") bus.health().error("another station calls itself " + config.station.station);
    for (const link::Delivery& delivery : taken.deliveries) {
      const char* name = received_as(delivery.channel, robot());
      if (name == nullptr) continue;
      bus.health().count(name, "radio_bytes_received", static_cast<std::int64_t>(delivery.bytes.size()));
      bus.publish_bytes(name, delivery.bytes);
    }
  }

  void look_for_silence() {
    std::vector<link::Station::Change> changes;
    {
      const std::lock_guard lock(mutex);
      changes = station.changes(clock.now());
    }
    for (const auto& change : changes) {
      bus.health().count(change.station, change.silent ? "fell_silent" : "heard");
      if (change.silent) bus.health().warn(change.station + " has fallen silent");
    }
  }

  void subscribe_all() {
    const SubscriptionOptions small{.queue_capacity = 64, .max_bytes = kMaxMessageBytes};
    if (robot()) {
      bus.subscribe_bytes(channels::kMapPatch, {.queue_capacity = 1000, .max_bytes = kMaxPatchBytes},
                          [this](BytesView bytes) { send_patch(bytes); });
      bus.subscribe_bytes(channels::kRobotState, {.queue_capacity = 1, .max_bytes = kMaxMessageBytes},
                          [this](BytesView bytes) { send_state(bytes); });
      bus.subscribe_bytes(channels::kTourReport, small,
                          [this](BytesView bytes) { send_command(channels::kTourReport, Channel::kReport, bytes); });
    } else {
      bus.subscribe_bytes(channels::kTour, small,
                          [this](BytesView bytes) { send_command(channels::kTour, Channel::kTour, bytes); });
    }
    bus.subscribe_bytes(channels::kEstop, small, [this](BytesView bytes) { send_stop(bytes); });
    subscribe<base_request_t>(bus, channels::kBaseRequest, {}, [this](const base_request_t& m) { on_request(m); });
  }
};

TeamLinkProcess::TeamLinkProcess(const Config& config, Bus& bus, Clock& clock)
    : state_(std::make_unique<State>(config, bus, clock)) {
  State* state = state_.get();
  state->connect();
  state->subscribe_all();
  clock.every(from_seconds(1 / config.beat_hz), [state] {
    state->send_beat(true);
    state->look_for_silence();
    state->look_after_connection();
  });
}

TeamLinkProcess::~TeamLinkProcess() = default;

void TeamLinkProcess::finish() {
  state_->dds.reset();
}

}  // namespace arpent
