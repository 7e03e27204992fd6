// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Frame counters without their wraps. GigE Vision's block ids have 16 bits and skip zero (65535 is followed by 1;
// GigE Vision 2.0, 16.2.1); with extended ids and in USB3 Vision they have 64 bits.
#pragma once

#include <cstdint>
#include <optional>

namespace arpent::camera {

class FrameCounter {
 public:
  enum class Step : std::uint8_t { kForward, kRepeated, kBackward, kRestarted };
  struct Reading {
    Step step = Step::kForward;
    std::int64_t count = 0;   ///< rises for ever; one a frame
    std::int64_t missed = 0;  ///< frames between this and the last one that the device made but nobody saw
  };

  /// `period`: see Frame::id_period. An id beyond the period shows that the device uses extended ids.
  [[nodiscard]] Reading read(std::int64_t id, std::int64_t period);

 private:
  std::optional<std::int64_t> last_id_;
  std::int64_t count_ = 0;
};

}  // namespace arpent::camera
