// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Who of a team visits which clusters, and in which order: by time (the default: timed_tours.h, surface early and
// everybody home early), by TSGA as in the thesis (Alg. 2), or one nearest cluster each (NNB, Alg. 4).
#pragma once

#include <string>
#include <vector>

#include "planning/local/ground.h"
#include "planning/mission/roads.h"
#include "planning/tour/team.h"
#include "planning/tour/timed_tours.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

struct AllocationParams {
  std::string objective = "time";
  tour::TimedParams time;
  tour::TsgaParams tsga;
  tour::UtilityParams utility;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("objective", self.objective,
                  "time: least mean arrival and least time of the last robot; tsga: thesis Alg. 2; nnb: thesis Alg. 4",
                  config::one_of({"time", "tsga", "nnb"}));
    visitor.group("time", self.time, "the search of objective time");
    visitor.group("tsga", self.tsga, "the search of objective tsga");
    visitor.group("utility", self.utility, "eq. 2.3, for tsga and nnb");
  }
};

/// Viewpoints in the order of the visit, one list per robot; empty for a robot that gets none. Every cluster is given
/// out, those to which the ground shows no way last (nnb: one cluster each). Drives are priced on cells of twice the
/// ground's size.
[[nodiscard]] std::vector<std::vector<Viewpoint>> allocate(const Ground& ground, const std::vector<Cluster>& clusters,
                                                           const std::vector<RobotPlace>& robots,
                                                           const AllocationParams& params, const VisitTimes& times);

}  // namespace arpent::planning
