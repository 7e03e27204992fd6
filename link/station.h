// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a station decides about messages that come and go: which are too late, which came twice, which emergency stops
// are in force, who has fallen silent. It knows no transport and no clock; `now` is always the station's own monotonic
// clock, and clocks of two machines are never compared:
//
// - Silence counts from the local receipt of a station's last beat.
// - A command carries what its sender had last heard of each receiver: the receiver's own clock, echoed. At its arrival
//   it was sent at most `now - echo` ago, by the receiver's clock alone. That bound includes the way of the beat; a
//   sender that has not heard the receiver for long, or heard an earlier session of it, sends commands that are late.
//   Reports are facts and never late. Emergency stops are never late either: to stop is safe.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/time.h"
#include "link/params.h"
#include "link/types.h"

namespace arpent::link {

struct Delivery {
  Channel channel;
  Payload bytes;
};

/// What a message led to. `refused`, if not empty, is why it (or a part of it) led to nothing: "late", "repeated",
/// "incomplete", "stale" or "namesake".
struct Taken {
  std::vector<Delivery> deliveries;
  std::string refused;
};

class Station {
 public:
  using BytesView = std::span<const std::uint8_t>;

  /// `session`: drawn at random, so that it differs from the one before. Throws InputError for broken rules.
  Station(const StationParams& params, std::uint32_t session);

  [[nodiscard]] Beat beat(Time now) const;
  [[nodiscard]] Beat state(Time now, BytesView bytes) const;
  [[nodiscard]] Command command(Channel channel, BytesView bytes);
  /// The pieces of a patch; none if it is larger than kMaxParts pieces.
  [[nodiscard]] std::vector<Part> parts(BytesView bytes);
  /// An emergency stop was heard on the station's own bus: latched, and to be sent. nullopt if it is one that came over
  /// the radio before.
  [[nodiscard]] std::optional<Command> stop(BytesView bytes);
  /// The stop is not in force here any more. Other stations that were stopped stay stopped until they are released.
  void release() { stopped_ = false; }
  [[nodiscard]] bool stopped() const { return stopped_; }

  [[nodiscard]] Taken take(Time now, const Beat& beat);
  [[nodiscard]] Taken take(Time now, const Command& command);
  [[nodiscard]] Taken take(const Part& part);

  struct Change {
    std::string station;
    bool silent = false;
  };
  /// Stations that have fallen silent or come back since the last call.
  [[nodiscard]] std::vector<Change> changes(Time now);

  /// Nobody was heard since the transport was connected, or another station hears one that was not.
  [[nodiscard]] bool misses_somebody(Time now) const;
  /// The transport is connected anew from now on.
  void connected(Time now);
  /// Whether it should be: somebody was missed for a while. A lost packet can leave two ends of Cyclone's handshake in
  /// disagreement for 100 s (docs/decisions/0006). True once for each attempt; the next takes twice as long, because
  /// the other may as well be out of this station's reach.
  [[nodiscard]] bool should_reconnect(Time now);

 private:
  /// One station as heard.
  struct Peer {
    std::uint32_t session = 0;
    std::set<std::uint32_t> past_sessions = {};
    Time clock{};  ///< its own, of its newest beat
    Time heard{};  ///< our clock
    bool beating = false;
    bool silent = true;
    std::vector<std::string> hears = {};
    std::map<Channel, Time> newest = {};    ///< its clock, by channel of the beat
    std::uint32_t stop = 0;                 ///< the last that was delivered
    std::set<std::uint32_t> commands = {};  ///< the newest that were taken
    std::uint32_t tour = 0;                 ///< the last command that was one
    std::uint32_t patch = 0;                ///< the last that was whole
    std::uint32_t open_patch = 0;           ///< being put together
    std::vector<Payload> collected = {};    ///< of it
  };

  /// nullptr if the message must not be used: `refused` says why.
  Peer* known(const std::string& station, std::uint32_t session, Taken& taken);
  void deliver_stop(Peer& peer, std::uint32_t number, const Payload& bytes, Taken& taken);
  [[nodiscard]] bool late(Time now, const Command& command) const;

  StationParams params_;
  std::uint32_t session_;
  std::uint32_t commands_ = 0;
  std::uint32_t patches_ = 0;
  std::uint32_t stops_ = 0;
  bool stopped_ = false;
  Payload stop_message_;
  std::deque<Payload> delivered_stops_;  ///< our bus says them back to us
  std::map<std::string, Peer> peers_;
  std::set<std::string> met_;  ///< heard since the transport was connected
  std::optional<Time> missing_since_;
  Duration patience_;
};

}  // namespace arpent::link
