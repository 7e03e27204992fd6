// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/exchange/teammate_poses.h"

#include <algorithm>
#include <cmath>

namespace arpent::mapping {
namespace {

/// A twist says nothing about what comes later, or was earlier, than this.
constexpr double kTwistHoldsS = 0.5;
constexpr double kLeastUncertaintyM = 0.02;
/// Of the extrapolated way.
constexpr double kUncertainShare = 0.3;
/// What a robot whose voice is gone may have gone on: v^2 / 2a and the time until its base noticed.
constexpr double kRunOutPerMps = 1.0;

}  // namespace

void TeammatePoses::note(const TeammateState& state) {
  const auto [held, is_new] = newest_.try_emplace(state.robot, state);
  if (!is_new && state.stamp > held->second.stamp) held->second = state;
}

std::vector<SeenTeammate> TeammatePoses::at(Time stamp) const {
  std::vector<SeenTeammate> seen;
  for (const auto& [robot, state] : newest_) {
    const double age_s = to_seconds(stamp - state.stamp);
    const double dt = std::clamp(age_s, -kTwistHoldsS, kTwistHoldsS);
    const double way_m = state.twist.speed_mps * dt, turn_rad = state.twist.turn_rate_radps * dt;
    const double heading = state.body.yaw_rad + 0.5 * turn_rad;
    SeenTeammate mate;
    mate.body = {state.body.x_m + way_m * std::cos(heading), state.body.y_m + way_m * std::sin(heading),
                 state.body.yaw_rad + turn_rad};
    mate.uncertainty_m = kLeastUncertaintyM + kUncertainShare * std::abs(way_m);
    if (age_s > kTwistHoldsS) mate.uncertainty_m += kRunOutPerMps * std::abs(state.twist.speed_mps) * dt;
    seen.push_back(mate);
  }
  return seen;
}

}  // namespace arpent::mapping
