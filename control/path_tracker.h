// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Follows a path with a differential base: model predictive control on the errors to a reference that moves along the
// path (thesis: MPC for a nonholonomic base, 0.5 m/s nominal). It knows the base's lag and delay, never breaks a limit,
// turns on the spot where it has to, stops smoothly, and brakes in the same cycle when it cannot do its work.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/time.h"
#include "control/limits.h"
#include "control/path.h"

namespace arpent::control {

struct TrackerParams {
  Limits limits;
  double period_s = 0.05;
  double lag_s = 0.1;
  double delay_s = 0.05;
  double max_pose_age_s = 0.3;
  double max_cross_track_m = 0.5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("limits", self.limits, "what the base may do");
    describe_tracking(self, visitor);
  }
  /// All but the limits, for processes that have them from the robot file.
  template <class Self, class Visitor>
  static void describe_tracking(Self& self, Visitor& visitor) {
    visitor.field("period_s", self.period_s, "time between two steps", config::between(0.005, 0.5));
    visitor.field("lag_s", self.lag_s, "time constant with which the base follows a command",
                  config::between(0.0, 2.0));
    visitor.field("delay_s", self.delay_s, "time until a command reaches the base", config::between(0.0, 1.0));
    visitor.field("max_pose_age_s", self.max_pose_age_s, "an older pose is stale: brake", config::greater_than(0.0));
    visitor.field("max_cross_track_m", self.max_cross_track_m, "farther from the path than this: brake",
                  config::greater_than(0.0));
  }
};

/// Where the base is and how it moves, measured at `stamp`.
struct BaseState {
  Time stamp;
  Eigen::Vector2d p_map_m = Eigen::Vector2d::Zero();
  double yaw_rad = 0;
  Twist2 twist;
};

enum class TrackerMode : std::uint8_t {
  kIdle,        ///< no path
  kTurnToPath,  ///< on the spot, to the path's first heading
  kTrack,
  kTurnToGoal,  ///< on the spot, to the goal's heading
  kArrived,
  kBrake,  ///< see the reason
};

struct TrackerOutput {
  Twist2 command;
  TrackerMode mode = TrackerMode::kIdle;
  std::string reason;        ///< why it brakes
  double cross_track_m = 0;  ///< positive left of the path
  double remaining_m = 0;
};

class PathTracker {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit PathTracker(const TrackerParams& params);
  ~PathTracker();
  PathTracker(PathTracker&&) noexcept;
  PathTracker& operator=(PathTracker&&) noexcept;

  /// Replaces the path; the base goes on from the speed it has. Without a goal heading it stops as it comes.
  /// `backwards`: tail first.
  void follow(Path path, std::optional<double> goal_heading_rad, bool backwards = false);
  /// Brakes to a stand on the arc that is being driven and forgets the path.
  void stop();
  /// The base has been stopped by other means: what was commanded before is void.
  void halt();
  /// One cycle of braking at the limit on the arc that is being driven, for a reason that the caller knows; the path is
  /// kept.
  [[nodiscard]] TrackerOutput brake(Time now, const std::string& reason);
  /// One cycle. Never throws; a state that is not finite or stale makes it brake. Commands stay within the limits from
  /// one call to the next, even if it comes early.
  [[nodiscard]] TrackerOutput step(Time now, const BaseState& state);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::control
