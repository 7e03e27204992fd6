// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A place on a CAN bus. Drivers know this interface only; behind it is a network interface, a bus in memory, or a log.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/time.h"
#include "drivers/can/can_frame.h"

namespace arpent::can {

/// ISO 11898 fault confinement, and what lies beyond it.
enum class PortState : std::int8_t {
  kActive = 0,
  kPassive = 1,  ///< many errors: still sends and receives
  kBusOff = 2,   ///< takes no part until it is restarted
  kGone = 3,     ///< the interface is not there (unplugged)
};

[[nodiscard]] const char* describe(PortState state);

/// Since the port was opened.
struct PortCounters {
  std::int64_t refused = 0;       ///< frames that were not taken
  std::int64_t error_frames = 0;  ///< what the controller says of errors on the bus
  std::int64_t overflows = 0;     ///< frames that came and found no room
  std::int64_t restarts = 0;      ///< the bus was lost and is there again
};

class CanPort {
 public:
  virtual ~CanPort() = default;
  /// False if the frame was not taken (queue full, bus off, gone); it is the caller's to drop or send anew.
  [[nodiscard]] virtual bool send(const CanFrame& frame) = 0;
  /// The next frame that has arrived by now, with its time of arrival; nullopt if there is none. Own frames never.
  [[nodiscard]] virtual std::optional<LoggedFrame> receive() = 0;
  /// Ends a batch of sent frames: ports that pack frames into messages send them now, others have sent already.
  virtual void flush() {}
  [[nodiscard]] virtual PortState state() const = 0;
  [[nodiscard]] virtual PortCounters counters() const = 0;
  /// Why it is not there, for people; empty if it is or if there is no more to say than its state.
  [[nodiscard]] virtual std::string fault() const { return {}; }
};

}  // namespace arpent::can
