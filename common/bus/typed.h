// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Typed messages on a bus. Every received message is measured and walked by the guard (wire_schema.h) before the
// generated decoder sees a byte; what does not pass is counted and dropped. Gaps in a message's `sequence` are counted
// as lost. No exception leaves a handler.
#pragma once

#include <string>

#include "common/bus/bus.h"

namespace arpent {

/// Encodes with LCM's own encoding, fingerprint first.
template <class Message>
[[nodiscard]] Bytes encode(const Message& message) {
  Bytes bytes(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

template <class Message>
void publish(Bus& bus, const std::string& channel, const Message& message) {
  bus.publish_bytes(channel, encode(message));
}

namespace detail {

/// Reason why `bytes` cannot be a message of `type`, empty if they can.
[[nodiscard]] std::string guard(const char* type, BytesView bytes);

/// Counts a gap between `last` and `sequence` as lost; a sequence that goes back is a restarted source.
void count_gap(Health& health, const std::string& channel, std::int64_t& last, std::int64_t sequence);

/// Runs `handle`, counting it, its CPU time, and an exception as failed.
void run_handler(Health& health, const std::string& channel, const std::function<void()>& handle);

}  // namespace detail

/// Decodes after the guard; nullopt-like: false if the bytes are not a message of this type.
template <class Message>
[[nodiscard]] bool decode_guarded(BytesView bytes, Message& message, std::string& fault) {
  fault = detail::guard(Message::getTypeName(), bytes);
  if (!fault.empty()) return false;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) fault = "the decoder refused it";
  return fault.empty();
}

/// `use(const Message&)` is called if the bytes are a message of this type; else they are passed over.
template <class Message, class Use>
void decode(BytesView bytes, Use use) {
  Message message;
  std::string fault;
  if (decode_guarded(bytes, message, fault)) use(message);
}

/// `handler(const Message&)` is called for each message that can be decoded.
template <class Message, class Handler>
void subscribe(Bus& bus, const std::string& channel, const SubscriptionOptions& options, Handler handler) {
  Health& health = bus.health();
  auto receive = [&health, channel, handler, last = std::int64_t{-1}](BytesView bytes) mutable {
    Message message;
    std::string fault;
    if (!decode_guarded(bytes, message, fault)) {
      health.count(channel, "undecodable");
      health.warn(channel + ": undecodable message dropped: " + fault);
      return;
    }
    if constexpr (requires { message.sequence; }) detail::count_gap(health, channel, last, message.sequence);
    detail::run_handler(health, channel, [&] { handler(message); });
  };
  bus.subscribe_bytes(channel, options, receive);
}

}  // namespace arpent
