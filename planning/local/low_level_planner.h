// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The low-level planner (thesis Alg. 1, 3; Sect. 2.5.3): takes a tour, gives out one leg after the other, and watches
// that the leg stays free (ObstacleCheck), that the goal is reached (GoalReached) and that the tour is still worth
// driving (UtilityCheck). A pure state machine: it is stepped with what is known now and answers with what to do. The
// rules of traffic decide elsewhere and come in as advice (Alg. 3). Stopping for what suddenly stands ahead is the stop
// guard's (stop_guard.h).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "planning/local/unreachable.h"

namespace arpent::planning {

struct LowLevelParams {
  double goal_tolerance_m = 0.1;
  double goal_tolerance_rad = 0.1;
  double completed_share = 0.8;
  bool judge_while_driving = true;
  bool bypass_obstacles = true;
  double obstacle_depth_m = 0.03;
  double max_off_leg_m = 0.5;
  double deceleration_mps2 = 0.35;
  LegPlannerParams leg;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("goal_tolerance_m", self.goal_tolerance_m, "a goal nearer than this is reached",
                  config::between(0.01, 1.0));
    visitor.field("goal_tolerance_rad", self.goal_tolerance_rad, "and its heading within this",
                  config::between(0.01, 3.2));
    visitor.field("completed_share", self.completed_share,
                  "share of the tour's incomplete surface elements after whose completion it is planned anew (c_thres)",
                  config::between(0.01, 1.0));
    visitor.field("judge_while_driving", self.judge_while_driving,
                  "ask for a new tour while a leg is driven, not only between legs");
    visitor.field("bypass_obstacles", self.bypass_obstacles,
                  "look for another way to the same goal before stopping for an obstacle");
    visitor.field("obstacle_depth_m", self.obstacle_depth_m,
                  "a leg is blocked when the footprint would reach deeper than this", config::between(0.0, 0.2));
    visitor.field("max_off_leg_m", self.max_off_leg_m, "farther from its leg than this the robot gets a new one",
                  config::between(0.05, 5.0));
    visitor.field("deceleration_mps2", self.deceleration_mps2,
                  "with which a robot stops on its path; it gets no leg that ends or turns sooner",
                  config::greater_than(0.0));
    visitor.group("leg", self.leg, "how legs are found");
  }
};

struct TourTarget {
  std::int64_t id = 0;  ///< the caller's, handed back
  Pose2 pose;
};

struct Tour {
  std::vector<TourTarget> targets;  ///< in the order of the visit
  /// The incomplete surface elements that it set out to complete, by voxel; frozen at planning time (C_start).
  std::vector<mapping::VoxelIndex> elements;
};

/// What the rules of traffic say (Alg. 3): go, or stand still until they say go.
enum class TrafficAdvice : std::uint8_t { kGo, kYield };

/// Faster than this a robot does not turn where it is.
inline constexpr double kStandsMps = 0.05;

struct LowLevelInput {
  const Ground& ground;    ///< of the newest map
  const GroundGrid& grid;  ///< that it was made from
  Pose2 pose;
  TrafficAdvice traffic = TrafficAdvice::kGo;
  double speed_mps = 0;  ///< along the heading
};

enum class DriveOrder : std::uint8_t {
  kGoOn,    ///< with what was ordered before; at first: stand
  kFollow,  ///< the new leg, instead of anything before
  kStop,
};

enum class ReplanReason : std::uint8_t {
  kNone,
  kNoTour,            ///< none was ever given, or the last one was used up
  kTourDone,          ///< its last target was visited
  kUtility,           ///< enough of what it set out to complete is complete
  kObstacle,          ///< the leg is blocked and there is no other way
  kNothingReachable,  ///< no leg leads to any target that is left
};
[[nodiscard]] const char* to_text(ReplanReason reason);

struct SkippedTarget {
  std::int64_t id = 0;
  NoLeg reason = NoLeg::kNoWay;
};

struct LowLevelOutput {
  DriveOrder order = DriveOrder::kGoOn;
  std::optional<Leg> leg;                     ///< with kFollow
  ReplanReason replan = ReplanReason::kNone;  ///< why a new tour is needed; repeated until one comes
  std::optional<std::int64_t> visited;        ///< target reached in this step
  std::vector<SkippedTarget> skipped;         ///< found unreachable in this step
};

class LowLevelPlanner {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit LowLevelPlanner(const LowLevelParams& params);

  /// Replaces the tour. A leg that is being driven goes on if it leads to the new tour's first target.
  void set_tour(Tour tour);
  /// The incomplete surface elements of the newest map; called whenever they were extracted.
  void set_incomplete(std::span<const mapping::VoxelIndex> elements);
  /// One step. Deterministic.
  [[nodiscard]] LowLevelOutput step(const LowLevelInput& input);

  /// Share of the tour's elements that are complete now [0, 1]; 0 for a tour without elements.
  [[nodiscard]] double completed_share() const { return completed_share_; }
  /// The robot does not get on: its target counts as unreachable until something changes about where it stands, and the
  /// tour is void.
  void give_up_target(const LowLevelInput& input);
  /// The robot was stopped on its leg: the next one, to the same target, begins where it stands.
  void break_off() { driving_.reset(); }
  /// What was found unreachable may be tried again: teammates, which no map shows, have moved.
  void forget_unreachable() { unreachable_.clear(); }
  [[nodiscard]] const UnreachableGoals& unreachable() const { return unreachable_; }
  /// The target that is being driven to.
  [[nodiscard]] std::optional<TourTarget> target() const;

 private:
  struct Driving {
    Leg leg;
    LegProgress progress;
  };

  void drive(const LowLevelInput& input, LowLevelOutput& output);
  void begin_next_leg(const LowLevelInput& input, LowLevelOutput& output);
  [[nodiscard]] bool reached(const Pose2& pose) const;
  [[nodiscard]] bool overshoots(const Leg& leg, double speed_mps) const;
  [[nodiscard]] bool try_leg(const LowLevelInput& input, const TourTarget& target, LowLevelOutput& output);

  LowLevelParams params_;
  LegPlanner planner_;
  Tour tour_;
  std::size_t next_ = 0;  ///< target that is driven to, or is next
  double completed_share_ = 0;
  std::optional<Driving> driving_;
  ReplanReason waiting_for_ = ReplanReason::kNoTour;
  bool standing_ = true;  ///< the last order was to stop, or none was given
  UnreachableGoals unreachable_;
};

}  // namespace arpent::planning
