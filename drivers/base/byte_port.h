// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A stream of bytes to a motor base: a serial line, TCP or UDP. Each is opened again by itself every 200 ms when it is
// not there or goes away; none ever waits.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/time.h"
#include "drivers/can/reopening.h"

namespace arpent::base {

class BytePort {
 public:
  virtual ~BytePort() = default;
  /// False if not all bytes were taken.
  [[nodiscard]] virtual bool send(std::span<const std::uint8_t> bytes) = 0;
  /// What has arrived by now.
  [[nodiscard]] virtual std::vector<std::uint8_t> receive() = 0;
  [[nodiscard]] virtual bool open() const = 0;
  /// Why it is not open, for people.
  [[nodiscard]] virtual std::string fault() const = 0;
  /// Time that a telemetry frame spends on the line.
  [[nodiscard]] virtual Duration frame_time() const { return Duration(0); }
  /// Whether telemetry comes without its sync byte.
  [[nodiscard]] virtual bool bare_telemetry() const { return false; }
};

/// `spec`: "serial:DEVICE" (19200 8N1), "tcp:ADDRESS[:PORT]" (15020) or "udp:ADDRESS[:PORT]" (15000 for commands, ten
/// more for telemetry). Addresses are numeric. Throws InputError for a spec that cannot mean anything.
[[nodiscard]] std::unique_ptr<BytePort> open_byte_port(const std::string& spec, const Now& now);

}  // namespace arpent::base
