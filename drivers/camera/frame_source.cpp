// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera/frame_source.h"

#include <chrono>

namespace arpent::camera {
namespace {

/// steady_clock is CLOCK_MONOTONIC on Linux.
Duration monotonic_now() {
  return std::chrono::duration_cast<Duration>(std::chrono::steady_clock::now().time_since_epoch());
}

}  // namespace

HostTime::HostTime(Time bus_now) : bus_minus_monotonic_(bus_now.time_since_epoch() - monotonic_now()) {}

Time HostTime::now() const {
  return from_monotonic(monotonic_now());
}

}  // namespace arpent::camera
