// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/dds_types.h"

#include <algorithm>

namespace arpent::link {
namespace {

template <std::size_t n>
void set_name(char (&target)[n], const std::string& name) {
  static_assert(n == kMaxStationName + 1);
  name.copy(target, kMaxStationName);
}

template <class Sequence>
void borrow(Sequence& sequence, const Payload& payload) {
  sequence._maximum = sequence._length = static_cast<std::uint32_t>(payload.size());
  sequence._buffer = const_cast<std::uint8_t*>(payload.data());  // DDS reads only; its struct has no const
  sequence._release = false;
}

template <class Sequence>
Payload to_payload(const Sequence& sequence) {
  return sequence._length == 0 ? Payload{} : Payload(sequence._buffer, sequence._buffer + sequence._length);
}

}  // namespace

BorrowedBeat::BorrowedBeat(const Beat& message) : hears_(message.hears.size()) {
  set_name(sample.station, message.station);
  sample.channel = static_cast<std::uint8_t>(message.channel);
  sample.session = message.session;
  sample.stop = message.stop;
  sample.stopped = message.stopped;
  sample.clock_us = to_utime(message.clock);
  for (std::size_t i = 0; i < hears_.size(); ++i) message.hears[i].copy(hears_[i].data(), kMaxStationName);
  sample.hears._maximum = sample.hears._length = static_cast<std::uint32_t>(hears_.size());
  sample.hears._buffer = reinterpret_cast<decltype(sample.hears._buffer)>(hears_.data());
  borrow(sample.stop_message, message.stop_message);
  borrow(sample.state, message.state);
}

BorrowedPart::BorrowedPart(const Part& message) {
  set_name(sample.station, message.station);
  sample.session = message.session;
  sample.number = message.sequence;
  sample.index = message.index;
  sample.count = message.count;
  borrow(sample.data, message.data);
}

BorrowedCommand::BorrowedCommand(const Command& message) : heard_(message.heard.size()) {
  set_name(sample.station, message.station);
  sample.channel = static_cast<std::uint8_t>(message.channel);
  sample.session = message.session;
  sample.number = message.sequence;
  sample.stop = message.stop;
  for (std::size_t i = 0; i < heard_.size(); ++i) {
    set_name(heard_[i].station, message.heard[i].station);
    heard_[i].session = message.heard[i].session;
    heard_[i].clock_us = to_utime(message.heard[i].clock);
  }
  sample.heard._maximum = sample.heard._length = static_cast<std::uint32_t>(heard_.size());
  sample.heard._buffer = heard_.data();
  borrow(sample.data, message.data);
}

Beat to_beat(const arpent_link_BeatSample& sample) {
  Beat beat{.station = sample.station,
            .channel = static_cast<Channel>(sample.channel),
            .session = sample.session,
            .stop = sample.stop,
            .stopped = sample.stopped,
            .clock = from_utime(sample.clock_us),
            .hears = {},
            .stop_message = to_payload(sample.stop_message),
            .state = to_payload(sample.state)};
  for (std::uint32_t i = 0; i < sample.hears._length; ++i) beat.hears.emplace_back(sample.hears._buffer[i]);
  return beat;
}

Command to_command(const arpent_link_CommandSample& sample) {
  Command command{.station = sample.station,
                  .channel = static_cast<Channel>(sample.channel),
                  .session = sample.session,
                  .sequence = sample.number,
                  .stop = sample.stop,
                  .heard = {},
                  .data = to_payload(sample.data)};
  for (std::uint32_t i = 0; i < sample.heard._length; ++i) {
    const arpent_link_EchoSample& echo = sample.heard._buffer[i];
    command.heard.push_back({echo.station, echo.session, from_utime(echo.clock_us)});
  }
  return command;
}

Part to_part(const arpent_link_PartSample& sample) {
  return {sample.station, sample.session, sample.number, sample.index, sample.count, to_payload(sample.data)};
}

}  // namespace arpent::link
