// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/station.h"

#include <algorithm>

#include "common/config/config.h"

namespace arpent::link {
namespace {

constexpr std::size_t kRememberedStops = 64;
constexpr std::size_t kRememberedCommands = 1024;  ///< more than a sender ever sends again
/// A handshake that loses packets and still succeeds takes some seconds at 20 % loss.
constexpr Duration kFirstPatience = std::chrono::seconds(6);
constexpr Duration kLastPatience = std::chrono::seconds(240);
/// Past the transport's lease a station that was heard must shake hands again.
constexpr Duration kLease = std::chrono::seconds(70);

Payload copy(std::span<const std::uint8_t> bytes) {
  return {bytes.begin(), bytes.end()};
}

Payload join(const std::vector<Payload>& pieces) {
  Payload whole;
  for (const Payload& piece : pieces) whole.insert(whole.end(), piece.begin(), piece.end());
  return whole;
}

}  // namespace

Station::Station(const StationParams& params, std::uint32_t session)
    : params_(params), session_(session), patience_(kFirstPatience) {
  config::check(params, "station");
}

Beat Station::beat(Time now) const {
  Beat beat{.station = params_.station, .session = session_, .stop = stops_, .stopped = stopped_, .clock = now};
  for (const auto& [name, peer] : peers_) {
    if (!peer.silent) beat.hears.push_back(name);
  }
  if (stopped_) beat.stop_message = stop_message_;
  return beat;
}

Beat Station::state(Time now, BytesView bytes) const {
  Beat with_state = beat(now);
  with_state.channel = Channel::kState;
  with_state.state = copy(bytes);
  return with_state;
}

Command Station::command(Channel channel, BytesView bytes) {
  Command command{.station = params_.station,
                  .channel = channel,
                  .session = session_,
                  .sequence = ++commands_,
                  .heard = {},
                  .data = copy(bytes)};
  for (const auto& [name, peer] : peers_) {
    if (peer.beating) command.heard.push_back({name, peer.session, peer.clock});
  }
  return command;
}

std::vector<Part> Station::parts(BytesView bytes) {
  const std::size_t count = std::max<std::size_t>(1, (bytes.size() + kPartBytes - 1) / kPartBytes);
  if (count > kMaxParts) return {};
  ++patches_;
  std::vector<Part> parts;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t begin = i * kPartBytes;
    parts.push_back({params_.station, session_, patches_, static_cast<std::uint16_t>(i),
                     static_cast<std::uint16_t>(count),
                     copy(bytes.subspan(begin, std::min(kPartBytes, bytes.size() - begin)))});
  }
  return parts;
}

std::optional<Command> Station::stop(BytesView bytes) {
  const Payload message = copy(bytes);
  if (std::find(delivered_stops_.begin(), delivered_stops_.end(), message) != delivered_stops_.end()) return {};
  stopped_ = true;
  stop_message_ = message;
  Command event = command(Channel::kStop, bytes);
  event.stop = ++stops_;
  return event;
}

Station::Peer* Station::known(const std::string& station, std::uint32_t session, Taken& taken) {
  if (station == params_.station) {
    taken.refused = "namesake";
    return nullptr;
  }
  const auto [found, is_new] = peers_.try_emplace(station);
  Peer& peer = found->second;
  if (is_new) {
    peer.session = session;
  } else if (peer.past_sessions.contains(session)) {
    taken.refused = "stale";
    return nullptr;
  } else if (peer.session != session) {
    std::set<std::uint32_t> past = std::move(peer.past_sessions);
    past.insert(peer.session);
    peer = Peer{.session = session, .past_sessions = std::move(past), .silent = peer.silent};
  }
  return &peer;
}

void Station::deliver_stop(Peer& peer, std::uint32_t number, const Payload& bytes, Taken& taken) {
  if (number <= peer.stop) return;
  peer.stop = number;
  delivered_stops_.push_back(bytes);
  if (delivered_stops_.size() > kRememberedStops) delivered_stops_.pop_front();
  taken.deliveries.push_back({Channel::kStop, bytes});
}

Taken Station::take(Time now, const Beat& beat) {
  Taken taken;
  Peer* peer = known(beat.station, beat.session, taken);
  if (peer == nullptr) return taken;
  peer->heard = now;
  peer->clock = peer->beating ? std::max(peer->clock, beat.clock) : beat.clock;
  peer->beating = true;
  peer->hears = beat.hears;
  met_.insert(beat.station);
  if (beat.stopped) deliver_stop(*peer, beat.stop, beat.stop_message, taken);
  if (beat.channel != Channel::kState) return taken;
  const auto [newest, first] = peer->newest.try_emplace(beat.channel, beat.clock);
  if (!first && beat.clock <= newest->second) {
    taken.refused = "stale";
    return taken;
  }
  newest->second = beat.clock;
  taken.deliveries.push_back({Channel::kState, beat.state});
  return taken;
}

bool Station::late(Time now, const Command& command) const {
  const auto echo = std::find_if(command.heard.begin(), command.heard.end(),
                                 [&](const Echo& e) { return e.station == params_.station && e.session == session_; });
  return echo == command.heard.end() || now - echo->clock > from_seconds(params_.command_expiry_s);
}

Taken Station::take(Time now, const Command& command) {
  Taken taken;
  Peer* peer = known(command.station, command.session, taken);
  if (peer == nullptr) return taken;
  if (!peer->commands.insert(command.sequence).second) {
    taken.refused = "repeated";
    return taken;
  }
  if (peer->commands.size() > kRememberedCommands) peer->commands.erase(peer->commands.begin());
  if (command.channel == Channel::kStop) {
    deliver_stop(*peer, command.stop, command.data, taken);
  } else if (command.channel == Channel::kTour && (late(now, command) || command.sequence < peer->tour)) {
    taken.refused = "late";  // or one that was sent again, after a newer one
  } else {
    if (command.channel == Channel::kTour) peer->tour = command.sequence;
    taken.deliveries.push_back({command.channel, command.data});
  }
  return taken;
}

Taken Station::take(const Part& part) {
  Taken taken;
  Peer* peer = known(part.station, part.session, taken);
  if (peer == nullptr) return taken;
  if (part.sequence <= peer->patch) {
    taken.refused = "repeated";
    return taken;
  }
  if (part.index == 0) {
    if (!peer->collected.empty()) taken.refused = "incomplete";  // the one before
    peer->open_patch = part.sequence;
    peer->collected.clear();
  }
  if (part.count == 0 || part.count > kMaxParts || part.data.size() > kPartBytes || part.sequence != peer->open_patch ||
      part.index != peer->collected.size() || part.index >= part.count) {
    taken.refused = "incomplete";
    return taken;
  }
  peer->collected.push_back(part.data);
  if (peer->collected.size() < part.count) return taken;
  peer->patch = part.sequence;
  taken.deliveries.push_back({Channel::kPatch, join(peer->collected)});
  peer->collected.clear();
  return taken;
}

void Station::connected(Time now) {
  met_.clear();
  missing_since_ = now;
}

bool Station::misses_somebody(Time now) const {
  const auto met = [&](const std::string& name) {
    return name == params_.station || (met_.contains(name) && now - peers_.at(name).heard < kLease);
  };
  return met_.empty() || std::any_of(peers_.begin(), peers_.end(), [&](const auto& entry) {
           const Peer& peer = entry.second;
           return !peer.silent && !std::all_of(peer.hears.begin(), peer.hears.end(), met);
         });
}

bool Station::should_reconnect(Time now) {
  if (!misses_somebody(now)) {
    missing_since_.reset();
    patience_ = kFirstPatience;
    return false;
  }
  if (!missing_since_) missing_since_ = now;
  // Two stations that miss each other do not both start anew at once: up to half as long again, by the session.
  if (now - *missing_since_ < patience_ + patience_ * (session_ % 16) / 32) return false;
  missing_since_ = now;
  patience_ = std::min(2 * patience_, kLastPatience);
  return true;
}

std::vector<Station::Change> Station::changes(Time now) {
  std::vector<Change> changes;
  for (auto& [name, peer] : peers_) {
    const bool silent = !peer.beating || now - peer.heard > from_seconds(params_.silent_after_s);
    if (silent != peer.silent) changes.push_back({name, silent});
    peer.silent = silent;
  }
  return changes;
}

}  // namespace arpent::link
