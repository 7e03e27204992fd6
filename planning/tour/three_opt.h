// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The path inside a cluster: through all its viewpoints, from a given entry to a free end (thesis Sect. 2.5.1, Fig.
// B.2).
#pragma once

#include <vector>

#include "planning/tour/matrix.h"

namespace arpent::tour {

/// Sum of the legs along `path` (no return). `length` is n x n [m].
[[nodiscard]] double path_length(const Matrix& length, const std::vector<int>& path);

/// Exchanges up to three legs (two neighbouring pieces change places or directions) as long as the open path becomes
/// shorter; its first node stays. Never longer than `path`. O(n^3) per pass over all exchanges: for clusters of some
/// tens of viewpoints.
[[nodiscard]] std::vector<int> three_opt(const Matrix& length, std::vector<int> path);

/// Through all n nodes from `entry`: nearest neighbours, then 3-opt.
[[nodiscard]] std::vector<int> intra_cluster_path(const Matrix& length, int entry);

}  // namespace arpent::tour
