// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Who visits what, as the thesis does it: TSGA (Sect. 3.5.1, Alg. 2) and its baseline NNB (Sect. 3.6.1, Alg. 4). The
// balanced allocation that a team uses by default is in timed_tours.h.
#pragma once

#include <vector>

#include "planning/tour/cluster_graph.h"
#include "planning/tour/max_atsp.h"

namespace arpent::tour {

struct TsgaParams {
  /// For each of the clusters x robots trials.
  SolverParams trial{8, 2e4, 0};
  /// For each robot's own tour in the end.
  SolverParams final{12, 1e6, 0};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("trial", self.trial, "each trial of a cluster in a robot's tour");
    visitor.group("final", self.final, "each robot's tour in the end");
  }
};

/// TSGA: clusters in ascending order of their distance to the nearest robot (`start_distance_m`, robots x n; ties to
/// the lower number), each to the robot whose maxATSP gains most by it (ties to the lower robot), begun from the tour
/// that it had. One tour per robot; empty where a robot gets nothing. For dist-TSGA each robot calls it with what it
/// knows.
[[nodiscard]] std::vector<OpenTour> tsga(const Arcs& utility, const Matrix& start_distance_m, const TsgaParams& params);

/// NNB: for each robot in turn the cluster of greatest utility from its start. With `share` robots may pick the same,
/// as Alg. 4 is printed; without, a picked cluster is gone, and -1 means that none was left.
[[nodiscard]] std::vector<int> nearest_neighbour_picks(const Matrix& utility_from_start, bool share);

}  // namespace arpent::tour
