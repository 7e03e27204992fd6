// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Time inside the house: one strong type for measurement time, on std::chrono, in microseconds since the epoch.
// On the wire it is `int64_t utime`; only wire code and logs convert.
#pragma once

#include <chrono>
#include <cstdint>

namespace arpent {

/// Tag of the time base in which sensors stamp their measurements. It is never read: time comes from a Clock (clock.h).
struct MeasurementTimeBase {
  using rep = std::int64_t;
  using period = std::micro;
  using duration = std::chrono::duration<rep, period>;
  using time_point = std::chrono::time_point<MeasurementTimeBase>;
  static constexpr bool is_steady = false;
};

using Duration = MeasurementTimeBase::duration;
using Time = MeasurementTimeBase::time_point;

[[nodiscard]] constexpr Time from_utime(std::int64_t utime) {
  return Time(Duration(utime));
}
[[nodiscard]] constexpr std::int64_t to_utime(Time time) {
  return time.time_since_epoch().count();
}
[[nodiscard]] constexpr double to_seconds(Duration duration) {
  return static_cast<double>(duration.count()) * 1e-6;
}
/// Rounded to the nearest microsecond.
[[nodiscard]] constexpr Duration from_seconds(double seconds) {
  return Duration(static_cast<std::int64_t>(seconds * 1e6 + (seconds < 0 ? -0.5 : 0.5)));
}

}  // namespace arpent
