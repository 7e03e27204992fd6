// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The main job of one robot: it keeps a map, finds what surface is incomplete, plans a tour of viewpoints, and gives
// out one drive after the other until nothing is left that it could complete (thesis Ch. 2, 5). Pure: depth images,
// poses and the path tracker's word come in, drives go out. Tours take time to plan: they come into force
// `plan_latency_s` after they were begun, and the robot goes on meanwhile.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "common/time.h"
#include "mapping/exchange/map_patch.h"
#include "mapping/tsdf/tsdf_map.h"
#include "planning/local/fresh_obstacles.h"
#include "planning/local/low_level_planner.h"
#include "planning/local/recovery.h"
#include "planning/mission/tour_planner.h"
#include "planning/viewpoints/exploration_targets.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

struct ExplorerParams {
  ViewpointParams viewpoints;
  mapping::TsdfParams tsdf;
  GroundGridParams grid;
  FreshObstacleParams fresh;
  FootprintParams footprint;
  DriveCosts costs;
  LowLevelParams low_level;
  RecoveryParams recovery;
  TourParams tour;
  double footprint_margin_m = 0.05;
  double start_clearance_m = 0.8;
  double nominal_speed_mps = 0.5;
  double nominal_turn_rate_radps = 1.0;
  double visit_s = 2.0;
  int max_stay_images = 16;
  double plan_latency_s = 0.2;
  double replan_s = 2.0;
  double stuck_s = 3.0;
  bool led = false;
  double body_gap_m = 0.12;
  std::vector<double> region_min_m{-1e6, -1e6, -1e6};
  std::vector<double> region_max_m{1e6, 1e6, 1e6};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("viewpoints", self.viewpoints, "where to look from");
    visitor.group("tsdf", self.tsdf, "the map");
    visitor.group("grid", self.grid, "the ground as the map knows it");
    visitor.group("fresh", self.fresh, "what appears on free ground");
    visitor.group("footprint", self.footprint, "what the robot covers of it");
    visitor.group("costs", self.costs, "what drives cost");
    visitor.group("low_level", self.low_level, "legs and when to plan anew");
    visitor.group("recovery", self.recovery, "what to do when boxed in");
    visitor.group("tour", self.tour, "the order of clusters");
    visitor.field("footprint_margin_m", self.footprint_margin_m,
                  "by which the footprint is grown for planning (errors of map, pose, tracking), at least half a voxel",
                  config::between(0.0, 0.5));
    visitor.field("start_clearance_m", self.start_clearance_m,
                  "a disc of this radius around the start is declared free: the camera never sees it",
                  config::between(0.0, 5.0));
    visitor.field("nominal_speed_mps", self.nominal_speed_mps, "for the times of tours", config::greater_than(0.0));
    visitor.field("nominal_turn_rate_radps", self.nominal_turn_rate_radps, "the same", config::greater_than(0.0));
    visitor.field("visit_s", self.visit_s, "for the times of tours: stopping and looking at a viewpoint",
                  config::at_least(0.0));
    visitor.field("max_stay_images", self.max_stay_images, "longest stay at a viewpoint", config::at_least(1));
    visitor.field("plan_latency_s", self.plan_latency_s, "declared time to plan a tour", config::between(0.0, 10.0));
    visitor.field("replan_s", self.replan_s, "a tour is planned anew after so long, while it is driven",
                  config::greater_than(0.0));
    visitor.field("stuck_s", self.stuck_s, "standing with a leg to drive for so long means that it cannot be driven",
                  config::between(0.5, 600.0));
    visitor.field("led", self.led, "tours come from the centre of a team");
    visitor.field("body_gap_m", self.body_gap_m, "kept from teammates by legs, beside footprint_margin_m",
                  config::between(0.0, 1.0));
    visitor.field("region_min_m", self.region_min_m, "only surface within this box matters", config::finite_numbers(3));
    visitor.field("region_max_m", self.region_max_m, "its other corner", config::finite_numbers(3));
  }
};

/// How the robot fares on what was ordered last.
struct DriveState {
  bool arrived = false;  ///< the tracker stands at its end
  double remaining_m = 0;
  bool pushes = false;   ///< the tracker drives on along it, and nobody stops it: if it stands, it touches something
  bool blocked = false;  ///< somebody stopped the robot for something in its way
  double speed_mps = 0;  ///< along the heading
};

/// What the path tracker shall do now.
struct ExplorerOrder {
  enum class Kind : std::uint8_t { kGoOn, kDrive, kStop };
  Kind kind = Kind::kGoOn;
  DrivePiece piece;  ///< with kDrive
};

/// What became of a viewpoint: all looks were taken there, or the robot does not get there.
struct TargetEvent {
  enum class Kind : std::uint8_t { kVisited = 1, kUnreachable = 2 };
  Kind kind = Kind::kVisited;
  Pose2 target;
};

struct ExplorerStatus {
  std::size_t elements = 0;       ///< incomplete now
  std::size_t elements_ever = 0;  ///< that were incomplete at some time
  int clusters = 0;               ///< of the newest tour
  double left_s = -1;             ///< that it will take; negative if unknown
  int tours = 0;                  ///< planned so far
  int recoveries = 0;             ///< ways out of where it was stuck or boxed in
  int assumed_free = 0;           ///< how often the robot was boxed in by unknown ground and assumed it to be free
  bool done = false;
  bool boxed_in = false;  ///< the end as well: something is left, but the robot cannot get away from where it stands
  std::string activity;
};

class Explorer {
 public:
  /// Throws InputError for parameters that break their rules.
  Explorer(const ExplorerParams& params, const LevelCamera& camera);
  ~Explorer();

  /// Where the robot stands at the start, map frame.
  void begin(const Pose2& start);
  /// A depth image and where its camera and the body were.
  void integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body);
  /// One step, after each depth image and whenever the tracker has arrived.
  [[nodiscard]] ExplorerOrder step(Time now, const Pose2& pose, const DriveState& drive);

  /// The order in force is void (the mission was paused): plans anew from where the robot stands.
  void restart();

  // In a team (led).
  /// The tour from now on, in the order of the visit. What the robot is on its way to stays first.
  void follow(std::vector<Viewpoint> viewpoints, Time now);
  /// The team says that nothing is left to do.
  void finish();
  /// What a teammate saw. A fault if the patch cannot be fused.
  [[nodiscard]] Result<std::size_t> fuse(const mapping::MapPatch& patch);
  /// Where a teammate stands at the start: the ground is declared free there as at the robot's own.
  void declare_start(const Pose2& teammate);
  /// Teammates in the way of legs, now; and whether the rules of traffic let the robot drive.
  void set_traffic(std::vector<Pose2> bodies, TrafficAdvice advice);
  /// A manoeuvre off the way of a teammate from where it stands to where it wants to be, at least `clear_m` from it.
  /// False if there is none.
  [[nodiscard]] bool step_aside(Time now, const Pose2& pose, const Pose2& teammate, const Pose2& its_target,
                                double clear_m);
  /// Its tour cannot be driven: it is reported, and void.
  void give_up_tour();
  /// On its way there, looking from it, or kept from it.
  [[nodiscard]] std::optional<Pose2> target() const;
  /// Whether nothing is left on its tour.
  [[nodiscard]] bool idle() const;
  /// Whether teammates are all that keeps it from its targets.
  [[nodiscard]] bool kept_by_bodies() const;
  /// What happened since the last call.
  [[nodiscard]] std::vector<TargetEvent> take_events();

  [[nodiscard]] const ExplorerStatus& status() const;
  [[nodiscard]] const mapping::TsdfMap& map() const;
  /// Why each element that is incomplete now is so, for a robot at `pose`, and the poses that were tried.
  [[nodiscard]] ExplorationTargets::Certification certify(const Pose2& pose) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::planning
