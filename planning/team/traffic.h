// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The rules of traffic (thesis Alg. 3, Sect. 3.5.2 item 5): each robot looks at its own way and at those that its
// teammates have sent, and drives, stops, or makes room. A total order settles who goes first (the lower name), so that
// no deadlock can arise by symmetry; and nobody drives where what a teammate sweeps before it stands would touch it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "common/time.h"
#include "common/twist2.h"
#include "planning/local/low_level_planner.h"

namespace arpent::planning {

struct TrafficParams {
  double gap_m = 0.08;
  double deceleration_mps2 = 0.5;
  double delay_s = 0.4;
  double nominal_speed_mps = 0.45;
  double horizon_s = 4.0;
  double slack_s = 1.0;
  double release_s = 0.6;
  double near_m = 2.0;
  double aside_clear_m = 0.95;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("gap_m", self.gap_m, "kept between footprints, whatever happens", config::between(0.0, 1.0));
    visitor.field("deceleration_mps2", self.deceleration_mps2, "with which bases surely brake",
                  config::between(0.05, 10.0));
    visitor.field("delay_s", self.delay_s, "until they do: radio, cycle, base", config::between(0.0, 3.0));
    visitor.field("nominal_speed_mps", self.nominal_speed_mps, "of robots that are about to drive",
                  config::between(0.05, 5.0));
    visitor.field("horizon_s", self.horizon_s, "so far ahead ways are compared", config::between(0.0, 20.0));
    visitor.field("slack_s", self.slack_s, "by which a teammate may be earlier or later", config::between(0.0, 5.0));
    visitor.field("release_s", self.release_s, "a stop ends when the way was clear for so long",
                  config::between(0.0, 10.0));
    visitor.field("near_m", self.near_m, "moving teammates nearer than this are in the way of new legs",
                  config::between(0.5, 20.0));
    visitor.field("aside_clear_m", self.aside_clear_m, "distance from a teammate's way that makes room for it",
                  config::between(0.5, 5.0));
  }
};

/// A robot as traffic sees it.
struct Vehicle {
  std::string name;
  Pose2 pose;
  Twist2 twist;
  std::vector<Eigen::Vector2d> path_m;                   ///< that it is about to drive; empty: it stays
  bool backwards = false;                                ///< along it
  std::optional<double> end_heading_rad = std::nullopt;  ///< to which it turns on the spot there
  bool lost = false;  ///< it is silent: it stands at one of its resting places, and nobody waits for it
};

/// Where a robot that fell silent may stand: from the pose of its last state as far along its arc as the dead man's
/// switch and the brakes take. At most 10 cm apart, the last pose first.
[[nodiscard]] std::vector<Pose2> resting_places(const Pose2& last, const Twist2& twist);

struct TrafficDecision {
  TrafficAdvice advice = TrafficAdvice::kGo;
  std::string because_of;  ///< the teammate that it stops for
};

class Traffic {
 public:
  /// Throws InputError for parameters that break their rules.
  Traffic(const TrafficParams& params, const Footprint& footprint);

  /// `own.path_m`: the way that it drives, or, when it was stopped, would drive.
  [[nodiscard]] TrafficDecision step(Time now, const Vehicle& own, const std::vector<Vehicle>& others);
  /// Whether a new way may be begun; if not, the robot is stopped as by step().
  [[nodiscard]] bool may_start(Time now, const Vehicle& own, const std::vector<Vehicle>& others);

 private:
  [[nodiscard]] bool must_brake(const Vehicle& own, const Vehicle& other) const;
  [[nodiscard]] bool must_yield(const Vehicle& own, const Vehicle& other) const;
  [[nodiscard]] double stopping_m(double speed_mps) const;

  TrafficParams params_;
  Footprint footprint_;
  std::optional<Time> stopped_at_;  ///< for the last time that somebody was in the way
  std::string because_of_;
};

}  // namespace arpent::planning
