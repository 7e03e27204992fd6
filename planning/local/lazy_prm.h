// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The thesis' path planner, for comparison: LazyPRM* in SE(2) (K. Hauser, "Lazy collision checking in asymptotically-
// optimal motion planning", 2015; thesis Sect. 1.4.3, 2.5.3), from OMPL. Each query gets a fresh roadmap: OMPL 1.5
// keeps what it once found valid, deletes for good what once was not, and grows from query to query, so that a roadmap
// that is kept drives through new walls and slows down from milliseconds to seconds.
#pragma once

#include <optional>

#include "planning/local/leg.h"

namespace arpent::planning {

struct LazyPrmParams {
  int max_samples = 600;
  int max_checks = 100000;
  int seed = 1;
  double turn_radius_m = 0.5;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("max_samples", self.max_samples, "vertices of the roadmap of one query", config::between(10, 5000));
    visitor.field("max_checks", self.max_checks, "poses and edges that one query may check", config::at_least(100));
    visitor.field("seed", self.seed, "of the samples; the same for each query", config::at_least(0));
    visitor.field("turn_radius_m", self.turn_radius_m, "corners are rounded with it where that fits",
                  config::between(0.1, 5.0));
  }
};

struct LazyPrmResult {
  std::optional<Motions> motions;  ///< forwards, corners rounded or turned on the spot
  int samples = 0;
};

/// Takes its whole budget of samples, as the star variant does. Deterministic.
[[nodiscard]] LazyPrmResult plan_lazy_prm(const Ground& ground, const Pose2& start, const Pose2& goal,
                                          const LazyPrmParams& params, const StartSlack& slack);

}  // namespace arpent::planning
