// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What stations (robots and the ground station) send each other, around LCM messages that nobody here looks into. A
// station's `session` is drawn anew at each start of its process: numbers and clocks of two sessions are never
// compared.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/time.h"

namespace arpent::link {

using Payload = std::vector<std::uint8_t>;

inline constexpr std::size_t kMaxStationName = 31;

enum class Channel : std::uint8_t { kBeat = 0, kState = 1, kTour = 2, kReport = 3, kStop = 4, kPatch = 5 };

/// Sent many times a second, never repeated: the sign of life, the emergency stop as a state, and the newest state.
struct Beat {
  std::string station;
  Channel channel = Channel::kBeat;  ///< kBeat: without a state
  std::uint32_t session = 0;
  std::uint32_t stop = 0;               ///< counts the station's emergency stops
  bool stopped = false;                 ///< the last of them is still in force
  Time clock{};                         ///< the sender's own, at sending
  std::vector<std::string> hears = {};  ///< the stations that the sender hears now
  Payload stop_message = {};            ///< while stopped
  Payload state = {};
};

/// What a sender had last heard of a receiver: that receiver's own clock, thrown back to it.
struct Echo {
  std::string station;
  std::uint32_t session = 0;
  Time clock{};
};

/// Reliable and in order, for as long as sender and receiver know each other.
struct Command {
  std::string station;
  Channel channel = Channel::kTour;
  std::uint32_t session = 0;
  std::uint32_t sequence = 0;  ///< counts the station's commands from 1
  std::uint32_t stop = 0;      ///< kStop: which
  std::vector<Echo> heard = {};
  Payload data = {};
};

/// A piece of a patch, at most kPartBytes of it. Kept by the sender for those who come late.
struct Part {
  std::string station;
  std::uint32_t session = 0;
  std::uint32_t sequence = 0;  ///< of the patch, counted from 1
  std::uint16_t index = 0;
  std::uint16_t count = 1;
  Payload data = {};
};

inline constexpr std::size_t kPartBytes = 8000;
inline constexpr std::size_t kMaxParts = 64;

}  // namespace arpent::link
