// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Finds the motions of a leg: A* over short arcs and turns on the spot, guided by a sweep from the goal, whose nodes
// are tried to be joined to the goal directly (hybrid A*: D. Dolgov et al., "Path planning for autonomous vehicles in
// unknown semi-structured environments", 2010; here forwards only, with turns on the spot). What it finds is then
// shortened where arcs of larger radius fit. Deterministic; its budget is a number of expansions.
#pragma once

#include <optional>

#include "planning/local/leg.h"
#include "planning/local/sweep.h"

namespace arpent::planning {

struct LatticeParams {
  double turn_radius_m = 0.5;
  double step_m = 0.25;
  int max_expansions = 10000;
  int max_refining_expansions = 600;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("turn_radius_m", self.turn_radius_m,
                  "arcs are not tighter than this; where it does not fit, turn on "
                  "the spot",
                  config::between(0.1, 5.0));
    visitor.field("step_m", self.step_m, "length of an arc of the search", config::between(0.1, 1.0));
    visitor.field("max_expansions", self.max_expansions, "budget of a search", config::at_least(1));
    visitor.field("max_refining_expansions", self.max_refining_expansions, "of these, after the first way was found",
                  config::at_least(0));
  }
};

struct LatticeResult {
  std::optional<Motions> motions;
  int expansions = 0;
  bool out_of_budget = false;
};

/// `to_goal` is a sweep from the goal's place over the same ground. The motions are free of contact but for the slack.
[[nodiscard]] LatticeResult search_lattice(const Ground& ground, const Pose2& start, const Pose2& goal,
                                           const Sweep& to_goal, const LatticeParams& params, const StartSlack& slack);

/// The cheapest of the direct ways between two poses (arcs of this radius and straight lines, turns on the spot) that
/// is free of contact and cheaper than `bound`; nullopt if there is none.
[[nodiscard]] std::optional<Motions> connect(const Ground& ground, const Pose2& start, const Pose2& goal,
                                             double radius_m, double bound, const StartSlack& slack);

/// Replaces parts of the way by direct connections wherever that is cheaper and free.
[[nodiscard]] Motions shorten(const Ground& ground, const Motions& motions, double radius_m, const StartSlack& slack);

}  // namespace arpent::planning
