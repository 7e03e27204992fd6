// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The centre of a team under one plan (thesis Ch. 3): fuses the robots' patches into one map, finds what surface is
// incomplete, and gives each robot its tour. Pure: patches, states and reports come in, tours go out. Asynchronous: a
// robot whose tour is used up gets a new one at once, a silent one holds nobody up: what it was given goes to others.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "mapping/exchange/map_patch.h"
#include "planning/team/allocation.h"
#include "planning/team/types.h"
#include "planning/viewpoints/exploration_targets.h"

namespace arpent::planning {

struct CentreParams {
  ViewpointParams viewpoints;
  mapping::TsdfParams tsdf;
  GroundGridParams grid;
  FootprintParams footprint;
  DriveCosts costs;
  AllocationParams allocation;
  double footprint_margin_m = 0.05;
  double start_clearance_m = 0.8;
  double body_gap_m = 0.12;
  double nominal_speed_mps = 0.5;
  double nominal_turn_rate_radps = 1.0;
  double visit_s = 2.0;
  double plan_latency_s = 0.3;
  double replan_s = 2.0;
  double early_replan_s = 0.6;
  double silent_s = 2.0;
  double valid_s = 3.0;
  int most_viewpoints = 12;
  double unreachable_s = 15.0;
  int unreachable_times = 3;
  std::vector<double> region_min_m{-1e6, -1e6, -1e6};
  std::vector<double> region_max_m{1e6, 1e6, 1e6};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("viewpoints", self.viewpoints, "where to look from");
    visitor.group("tsdf", self.tsdf, "the fused map; the lattice is that of all patches");
    visitor.group("grid", self.grid, "the ground as the map knows it");
    visitor.group("footprint", self.footprint, "what each robot covers of it");
    visitor.group("costs", self.costs, "what drives cost");
    visitor.group("allocation", self.allocation, "who visits what");
    visitor.field("footprint_margin_m", self.footprint_margin_m,
                  "by which footprints are grown for planning, at least half a voxel", config::between(0.0, 0.5));
    visitor.field("start_clearance_m", self.start_clearance_m,
                  "a disc of this radius around each robot's start is declared free", config::between(0.0, 5.0));
    visitor.field("body_gap_m", self.body_gap_m, "kept from robots that are lost", config::between(0.0, 1.0));
    visitor.field("nominal_speed_mps", self.nominal_speed_mps, "for the times of tours", config::greater_than(0.0));
    visitor.field("nominal_turn_rate_radps", self.nominal_turn_rate_radps, "the same", config::greater_than(0.0));
    visitor.field("visit_s", self.visit_s, "the same: stopping and looking at a viewpoint", config::at_least(0.0));
    visitor.field("plan_latency_s", self.plan_latency_s, "declared time to plan", config::between(0.0, 10.0));
    visitor.field("replan_s", self.replan_s, "tours are planned anew after so long", config::greater_than(0.0));
    visitor.field("early_replan_s", self.early_replan_s, "and after so long if a robot has nothing to do",
                  config::greater_than(0.0));
    visitor.field("silent_s", self.silent_s, "a robot that was not heard for so long is lost",
                  config::greater_than(0.0));
    visitor.field("valid_s", self.valid_s, "a robot refuses a tour planned from a state of its own older than this",
                  config::greater_than(0.0));
    visitor.field("most_viewpoints", self.most_viewpoints, "of one tour that are sent", config::between(1, 1000));
    visitor.field("unreachable_s", self.unreachable_s, "for so long a viewpoint that could not be reached is left out",
                  config::greater_than(0.0));
    visitor.field("unreachable_times", self.unreachable_times, "after so many times it is left out for good",
                  config::at_least(1));
    visitor.field("region_min_m", self.region_min_m, "only surface within this box matters", config::finite_numbers(3));
    visitor.field("region_max_m", self.region_max_m, "its other corner", config::finite_numbers(3));
  }
};

struct CentreStatus {
  std::size_t elements = 0;  ///< incomplete now
  int clusters = 0;          ///< of the newest plan
  int plans = 0;
  int running = 0;  ///< robots
  int lost = 0;
  std::int64_t patches = 0;
  bool done = false;
};

class Centre {
 public:
  /// Throws InputError for parameters that break their rules.
  Centre(const CentreParams& params, const LevelCamera& camera);
  ~Centre();

  /// A patch that was not taken before. A fault, and nothing changes, if it cannot be fused.
  [[nodiscard]] Result<std::size_t> take(const mapping::MapPatch& patch);
  /// `now`: of receipt, for how long a robot is silent.
  void take(const RobotState& state, Time now);
  void take(const TourReport& report, Time now);

  /// A tour that a centre before this one has sent: what reports speak of, and which number comes next.
  void recall(const TeamTour& tour);

  /// The tours that are due. Called ten times a second.
  [[nodiscard]] std::vector<TeamTour> step(Time now);

  [[nodiscard]] const mapping::TsdfMap& map() const;
  [[nodiscard]] const CentreStatus& status() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::planning
