// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What an explorer keeps, and its steps: those of a robot by itself in explorer.cpp, those of a member of a team in
// explorer_led.cpp. Private to these two.
#pragma once

#include <deque>

#include "planning/mission/explorer.h"
#include "planning/mission/standstill.h"

namespace arpent::planning {

struct Explorer::State {
  /// In a team.
  struct Team {
    std::vector<Pose2> bodies;
    TrafficAdvice advice = TrafficAdvice::kGo;
    std::vector<TargetEvent> events;
    Time retried_at{};
    int retries = 0;  ///< in a row, of a tour that teammates keep it from
  };
  Team team;
  ExplorerParams params;
  mapping::TsdfMap map;
  ExplorationTargets targets;
  GroundGrid grid;
  FreshObstacles fresh;
  Footprint body_footprint;
  Footprint footprint;  ///< the same with a margin, for planning
  LowLevelPlanner low_level;
  Trail trail;
  ExplorerStatus status;
  VoxelSet ever;
  std::vector<Eigen::Vector2d> assumed_free_m;
  /// A recovery that did not help here is not tried a third time.
  static constexpr int kRecoveriesPerPlace = 2;
  TriedPoses recovered_at;
  TriedPoses stopped_at;  ///< by others, for something in the way
  bool was_blocked = false;
  bool recovering = false;  ///< on pieces of a recovery, not of a leg
  bool looked_around = false;
  int chances = 3;  ///< of all that could not be reached, before the end
  int images = 0;
  std::optional<int> last_image;  ///< nothing is left to do, it seems: the decision falls after this one

  /// A tour that is thought out but not yet in force.
  struct Pending {
    Time begun, from;
    PlannedTour tour;
  };
  std::optional<Pending> pending;
  Tour tour;                          ///< in force: what is left of it
  std::vector<Viewpoint> viewpoints;  ///< of the tour in force, by target id
  Time adopted_at{};
  std::deque<DrivePiece> pieces;  ///< of the leg, that are still to be ordered
  /// Standing at a viewpoint until enough images were taken.
  struct Dwell {
    Viewpoint viewpoint;
    int images = 0;
  };
  std::optional<Dwell> dwell;
  struct Visit {
    Pose2 pose;
    Time at;
  };
  std::optional<Visit> last_visit;  ///< where all looks were taken
  Standstill standstill;
  std::optional<Time> helpless_since;  ///< no target was reachable, and it has not moved since

  State(const ExplorerParams& p, const LevelCamera& camera);

  void integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body);
  ExplorerOrder step(Time now, const Pose2& pose, const DriveState& drive);
  ExplorerOrder wait(const Pose2& pose);
  void drop_completed();
  void adopt(Time now);
  void plan(Time now, const Ground& ground, const Pose2& pose, ReplanReason reason);
  void end();
  [[nodiscard]] Targets find_targets(const Ground& ground, const Pose2& pose);
  bool assume_free(const Pose2& pose);
  [[nodiscard]] std::optional<Viewpoint> committed_viewpoint() const;
  void look_around(Time now, const Pose2& pose);
  void begin_dwell(std::int64_t target);
  ExplorerOrder order_for(Time now, const LowLevelOutput& output, bool arrived);
  ExplorerOrder next_piece();
  ExplorerOrder get_unstuck(Time now, const Ground& ground, const Pose2& pose, bool pushes);
  bool recover(Time now, const Pose2& pose, const std::optional<Recovery>& recovery, int most = kRecoveriesPerPlace);
  bool get_out(Time now, const Ground& ground, const Pose2& pose);
  bool is_helpless(Time now, ReplanReason reason);
  bool recover_by_the_way_it_came(Time now, const Ground& ground, const Pose2& pose);

  // In a team (explorer_led.cpp).
  [[nodiscard]] Ground ground_now(const Pose2& pose) const;
  void note_visit(const Viewpoint& viewpoint, Time now);
  void note_skipped(const LowLevelOutput& output);
  [[nodiscard]] bool has_room_to_turn(const Pose2& pose) const;
  void await_tour(Time now, const Ground& ground, const Pose2& pose, ReplanReason reason);
  void follow(std::vector<Viewpoint> given, Time now);
  bool step_aside(Time now, const Pose2& pose, const Pose2& teammate, const Pose2& its_target, double clear_m);
};

}  // namespace arpent::planning
