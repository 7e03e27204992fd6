// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A differential base as the path tracker believes it to be: delay, lag, and a yaw gain that is not quite one. For the
// tracker's tests and its benchmark; the simulator has its own, richer one.
#pragma once

#include <cmath>
#include <deque>

#include "control/path_tracker.h"

namespace arpent::control {

struct PlantParams {
  double lag_s = 0.1;
  double delay_s = 0.05;
  double yaw_gain = 1.03;
};

class Plant {
 public:
  Plant(const PlantParams& params, const BaseState& start) : params_(params), state_(start) {}

  [[nodiscard]] const BaseState& state() const { return state_; }
  /// Gives a command at the present time and moves on by `duration_s`.
  void move(const Twist2& command, double duration_s) {
    constexpr double kStepS = 1e-3;
    pending_.emplace_back(state_.stamp + from_seconds(params_.delay_s), command);
    const double keep = std::exp(-kStepS / params_.lag_s);
    for (const Time end = state_.stamp + from_seconds(duration_s); state_.stamp < end;
         state_.stamp += from_seconds(kStepS)) {
      while (!pending_.empty() && pending_.front().first <= state_.stamp) {
        command_ = pending_.front().second;
        pending_.pop_front();
      }
      Twist2& twist = state_.twist;
      twist.speed_mps = command_.speed_mps + keep * (twist.speed_mps - command_.speed_mps);
      const double turning = params_.yaw_gain * command_.turn_rate_radps;
      twist.turn_rate_radps = turning + keep * (twist.turn_rate_radps - turning);
      const double middle = state_.yaw_rad + 0.5 * twist.turn_rate_radps * kStepS;
      state_.p_map_m += twist.speed_mps * kStepS * Eigen::Vector2d(std::cos(middle), std::sin(middle));
      state_.yaw_rad += twist.turn_rate_radps * kStepS;
    }
  }

 private:
  PlantParams params_;
  BaseState state_;
  Twist2 command_;
  std::deque<std::pair<Time, Twist2>> pending_;
};

}  // namespace arpent::control
