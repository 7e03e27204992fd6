// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/host_time.h"

#include <chrono>

namespace arpent {
namespace {

template <class SystemClock>
Duration since_epoch() {
  return std::chrono::duration_cast<Duration>(SystemClock::now().time_since_epoch());
}

}  // namespace

// steady_clock is CLOCK_MONOTONIC on Linux, system_clock CLOCK_REALTIME.
HostTime::HostTime(Time bus_now)
    : bus_minus_monotonic_(bus_now.time_since_epoch() - since_epoch<std::chrono::steady_clock>()),
      bus_minus_realtime_(bus_now.time_since_epoch() - since_epoch<std::chrono::system_clock>()) {}

Time HostTime::now() const {
  return from_monotonic(since_epoch<std::chrono::steady_clock>());
}

}  // namespace arpent
