// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Plans the leg from where the robot is to a goal over known free ground, or says why there is none. Two planners
// answer alike: the lattice (default), and LazyPRM* as in the thesis (lazy_prm.h). Every leg is checked once more,
// whole, against the ground that it was asked for.
#pragma once

#include <optional>
#include <string>

#include "planning/local/lattice_search.h"
#include "planning/local/lazy_prm.h"

namespace arpent::planning {

struct LegPlannerParams {
  std::string planner = "lattice";
  double start_slack_m = 0.08;
  LatticeParams lattice;
  LazyPrmParams lazy_prm;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("planner", self.planner, "how legs are found", config::one_of({"lattice", "lazy_prm"}));
    visitor.field("start_slack_m", self.start_slack_m,
                  "so far the footprint may reach into what is not free where the robot stands already",
                  config::between(0.0, 0.5));
    visitor.group("lattice", self.lattice, "arcs and turns on the spot over the field of costs");
    visitor.group("lazy_prm", self.lazy_prm, "the thesis' random roadmap");
  }
};

enum class NoLeg : std::uint8_t {
  kStartUnknown,  ///< the robot stands on ground that was never seen
  kStartBlocked,  ///< the robot stands in something, or too close to turn or drive off
  kGoalUnknown,
  kGoalBlocked,
  kNoWay,     ///< not even the robot's width comes through
  kTooTight,  ///< its width comes through, but no way was found for the whole footprint
  kBudget,    ///< the search used up its steps
  kStuck,     ///< the robot stood on the way there and did not get on
};
[[nodiscard]] const char* to_text(NoLeg reason);

struct LegResult {
  std::optional<Leg> leg;
  NoLeg reason = NoLeg::kNoWay;  ///< if there is no leg
  int steps = 0;                 ///< that the search took: expansions, or samples
  /// As long as nothing changes on the ground here, a failure stays one (from a start within it).
  GroundBox region;
};

class LegPlanner {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit LegPlanner(const LegPlannerParams& params);

  /// Deterministic: the same ground, start and goal give the same leg, whatever was asked before. Poses that are not
  /// finite are a programmer's mistake.
  [[nodiscard]] LegResult plan(const Ground& ground, const Pose2& start, const Pose2& goal) const;

 private:
  [[nodiscard]] LegResult search(const Ground& ground, const Pose2& start, const Pose2& goal,
                                 const StartSlack& slack) const;

  LegPlannerParams params_;
};

}  // namespace arpent::planning
