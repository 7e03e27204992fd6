// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The side of mission_process that faces the team: what teammates and the centre say comes in, the robot's own state
// and what became of its viewpoints go out, the rules of traffic are applied, teammates are masked out of depth.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "mapping/exchange/teammate_poses.h"
#include "planning/mission/task.h"
#include "planning/team/traffic.h"
#include "planning/team/types.h"

namespace arpent {

struct TeamMemberParams {
  std::string robot;
  double silent_s = 1.5;
  planning::TrafficParams traffic;
  mapping::TeammateMaskParams mask;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("robot", self.robot, "the robot's name in its team; empty: it is alone");
    visitor.field("silent_s", self.silent_s, "a teammate that was not heard for so long stands where it is",
                  config::greater_than(0.0));
    visitor.group("traffic", self.traffic, "who stops for whom");
    visitor.group("mask", self.mask, "what teammates cover in depth");
  }
};

class TeamMember {
 public:
  /// Throws InputError for parameters that break their rules. The explorer must outlive it.
  TeamMember(const TeamMemberParams& params, const planning::FootprintParams& footprint, planning::Explorer& explorer,
             Bus& bus, Clock& clock);

  /// Makes teammates neutral in a depth image taken at `stamp`.
  void mask(Time stamp, stereo::DepthMap& depth, const Pose& T_map_cam) const;

  /// The robot's condition, ten times a second. Publishes ROBOT_STATE and TOUR_REPORT. True if the robot must stop now.
  [[nodiscard]] bool step(planning::MissionState mission, Time stamp, const Pose2& body, const Twist2& twist,
                          double position_sigma_m);
  /// Whether a new way may be begun now; remembers it as the way.
  [[nodiscard]] bool may_drive(const Pose2& body, const planning::PathRequest& way);
  /// The robot was stopped: it has no way any more, unless traffic stopped it.
  void note_stop();

 private:
  struct Teammate {
    planning::RobotState state;
    Time heard_at;
  };

  void listen();
  void take(const planning::RobotState& state);
  void take(const planning::TeamTour& tour);
  [[nodiscard]] std::vector<planning::Vehicle> vehicles() const;
  [[nodiscard]] planning::Vehicle own(const Pose2& body) const;
  [[nodiscard]] std::vector<Pose2> bodies_in_the_way(const Pose2& body) const;
  [[nodiscard]] std::string nearest_to(const Pose2& body) const;
  [[nodiscard]] std::vector<Eigen::Vector2d> way_ahead(const Eigen::Vector2d& body_m) const;
  void make_room(const Pose2& body);
  void report(planning::MissionState mission, Time stamp, const Pose2& body, double position_sigma_m);

  TeamMemberParams params_;
  planning::Traffic traffic_;
  planning::Explorer& explorer_;
  Bus& bus_;
  Clock& clock_;
  std::map<std::string, Teammate> teammates_;
  mapping::TeammatePoses poses_;
  planning::PathRequest way_;  ///< that it drives, or would drive when it was stopped by traffic
  Twist2 twist_;
  bool yields_ = false;
  std::string yields_to_;                    ///< for the last time
  int refused_ = 0;                          ///< ways in a row that could not be begun
  std::optional<Eigen::Vector2d> jammed_m_;  ///< where that happened too often for the last time
  std::int64_t tour_ = -1;
  std::optional<Time> newest_stamp_, aside_at_;
};

}  // namespace arpent
