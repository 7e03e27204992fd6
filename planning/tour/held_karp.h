// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Exact tours of few nodes by dynamic programming over subsets (Held and Karp 1962), O(n^2 2^n) time and O(n 2^n)
// memory: 12 clusters take about a millisecond, 16 about 50. For planning with few clusters, and as the truth in tests.
#pragma once

#include <vector>

#include "planning/tour/matrix.h"

namespace arpent::tour {

/// Nodes that fit: 2^18 subsets of 18 nodes are 38 MB.
constexpr int kMostExactNodes = 19;

/// Cheapest closed tour through all nodes of `cost` (n x n, 1 <= n <= kMostExactNodes; the diagonal is ignored;
/// infinite = forbidden), beginning with node 0. An open path from node 0 is the same with cost(j, 0) = 0.
[[nodiscard]] std::vector<int> exact_tour(const Matrix& cost);

/// The same when an arc's price depends on what is still to be visited: cost(i, j) times `base` plus the `weight` (one
/// per node, node 0's is not used) of all nodes not visited before j, j included. With times for costs this is the sum
/// of weighted arrival times plus `base` times the arrival at the last node (the arcs back to node 0 must be 0).
[[nodiscard]] std::vector<int> exact_weighted_tour(const Matrix& cost, double base, const std::vector<double>& weight);

}  // namespace arpent::tour
