// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Random planning problems as TSGA meets them: clusters of one to five viewpoints scattered over a place of 21 x 14 m,
// gains as shares of all, robots near one wall, Euclidean distances.
#pragma once

#include <vector>

#include "planning/tour/cluster_graph.h"

namespace arpent::bench {

[[nodiscard]] tour::ClusterGraph random_clusters(int clusters, int robots, unsigned seed);

/// The problems whose best tours are stored in tour_truth.csv.
struct TourCase {
  int clusters;
  double lambda_tc_1pm;
  unsigned seed;
};
[[nodiscard]] std::vector<TourCase> tour_cases();
/// Utility of the arcs from the only robot's start, one per cluster.
[[nodiscard]] std::vector<double> from_only_start(const tour::Arcs& arcs);

}  // namespace arpent::bench
