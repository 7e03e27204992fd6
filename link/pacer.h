// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How fast pieces of patches may follow each other. Cyclone DDS sends what it is given at once: without a pace a burst
// fills the radio's queue, and control waits in it (measured: 60 kB at once on 5 Mbit/s quadruples control's age).
#pragma once

#include <algorithm>

#include "common/time.h"

namespace arpent::link {

class Pacer {
 public:
  explicit Pacer(double rate_mbps) : rate_mbps_(rate_mbps) {}

  /// When a piece that is ready at `now` may be sent. Whoever asks sends it then.
  [[nodiscard]] Time next(Time now, std::size_t bytes) {
    const Time start = std::max(now, free_at_);
    free_at_ = start + from_seconds(8e-6 * static_cast<double>(on_air(bytes)) / rate_mbps_);
    return start;
  }

  /// With headers and seals, as measured with DDS Security.
  [[nodiscard]] static std::size_t on_air(std::size_t bytes) {
    constexpr std::size_t kFrame = 1100;
    constexpr std::size_t kFrameOverhead = 190;
    return bytes + kFrameOverhead * ((bytes + kFrame - 1) / kFrame);
  }

 private:
  double rate_mbps_;
  Time free_at_{};
};

}  // namespace arpent::link
