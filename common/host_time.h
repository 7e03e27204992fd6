// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The bus' clock as a value: for drivers whose devices stamp with the kernel's clocks, and for threads of a driver's
// own that may outlive the bus.
#pragma once

#include "common/time.h"

namespace arpent {

class HostTime {
 public:
  /// `bus_now`: the bus' clock at this moment.
  explicit HostTime(Time bus_now);
  [[nodiscard]] Time now() const;
  /// A stamp of CLOCK_MONOTONIC in the bus' time.
  [[nodiscard]] Time from_monotonic(Duration monotonic) const { return Time(monotonic + bus_minus_monotonic_); }
  /// A stamp of CLOCK_REALTIME in the bus' time; wrong by as much as that clock was set since the start.
  [[nodiscard]] Time from_realtime(Duration realtime) const { return Time(realtime + bus_minus_realtime_); }

 private:
  Duration bus_minus_monotonic_;
  Duration bus_minus_realtime_;
};

}  // namespace arpent
