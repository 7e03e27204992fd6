// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The way of one side of the base from a counter that wraps, is sometimes set to zero, gets stuck, or has its sign
// wrong: differences that can be are added up, others are reported and left out.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/time.h"

namespace arpent::base {

enum class OdometerFault : std::int8_t {
  kNone = 0,
  kReset = 1,    ///< the counter started anew; the way goes on
  kJump = 2,     ///< a difference that no wheel can make: left out
  kStuck = 3,    ///< does not move although it is told to
  kReversed = 4  ///< moves against its command
};

class Odometer {
 public:
  /// `unit_m`: way per count. `max_speed_mps`: what the wheel can do at most.
  Odometer(double unit_m, double max_speed_mps) : unit_m_(unit_m), max_speed_mps_(max_speed_mps) {}

  /// A reading of the counter, and the speed that this side is told to have.
  OdometerFault update(std::int32_t count, double commanded_mps, Time now);

  [[nodiscard]] double way_m() const { return way_m_; }

 private:
  [[nodiscard]] OdometerFault compare_with_command(double moved_m, double interval_s, double commanded_mps);

  double unit_m_;
  double max_speed_mps_;
  double way_m_ = 0;
  std::optional<std::int32_t> last_;
  Time last_at_{};

  /// The last half second in which this side was told to move one way.
  struct Step {
    double interval_s, told_m, moved_m;
  };
  std::deque<Step> window_;
  Step sum_{};
};

}  // namespace arpent::base
