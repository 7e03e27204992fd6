// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Lower bounds of the closed asymmetric travelling salesman problem (ATSP): the assignment relaxation, and above it the
// Held-Karp bound by subgradient ascent. The multipliers of either also tell which arcs are likely in good tours.
#pragma once

#include <vector>

#include "planning/tour/matrix.h"

namespace arpent::tour {

/// A lower bound and the multipliers that prove it: cost(i, j) - out[i] - in[j] is the reduced cost of an arc.
struct Bound {
  double value = 0;
  std::vector<double> out;
  std::vector<double> in;
};

/// Optimum of the assignment relaxation (each node is left once and entered once; sub-tours allowed) with its dual
/// solution: no reduced cost is negative. `cost` is n x n, n >= 2, finite off the diagonal, which is ignored.
/// Source: Kuhn's method with shortest augmenting paths, O(n^3).
[[nodiscard]] Bound assignment_bound(const Matrix& cost);

/// Raises `start` by at most `iterations` steps towards the Held-Karp bound; never returns less than `start`. `upper`
/// is the cost of any tour. O(n^2) each. Relaxation: a tour without node 0 is a spanning tree (here one that may ignore
/// directions), and node 0 is left once and entered once; the multipliers price each node's out- and in-degree.
/// Source: Held and Karp 1970; step sizes by Held, Wolfe and Crowder 1974.
[[nodiscard]] Bound held_karp_bound(const Matrix& cost, const Bound& start, double upper, int iterations);

}  // namespace arpent::tour
