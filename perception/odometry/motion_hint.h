// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What gyro and wheels say of the body's step from one pair to the next: not for the estimate, which the images alone
// make, but for where points are looked for first. Only readings that have surely come by the time of the estimate
// count, so that live and lockstep agree; the newest of them goes on until the pair's time.
#pragma once

#include <map>
#include <optional>

#include "common/geometry.h"
#include "common/time.h"

namespace arpent::odometry {

class MotionHint {
 public:
  /// Rate about body z. Readings may come in any order.
  void add_turn_rate(Time stamp, double rate_radps);
  /// Mean way of both sides since whenever, without jumps.
  void add_way(Time stamp, double way_m);
  /// The body at `to` seen from the body at `from`, on level ground. Where wheels are silent the speed is `speed_mps`.
  /// Nullopt if the gyro is silent. Forgets what is older than `to` needs: times may not go back.
  [[nodiscard]] std::optional<Pose> step(Time from, Time to, double speed_mps);

 private:
  [[nodiscard]] std::optional<double> turn_rad(Time from, Time to);
  [[nodiscard]] std::optional<double> way_m(Time from, Time to);

  std::map<Time, double> rates_radps_, ways_m_;
};

}  // namespace arpent::odometry
