// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The exact Euclidean distance transform of a grid: for every cell the squared distance to the nearest marked one
// (Meijster, Roerdink and Hesselink, "A general algorithm for computing distance transforms in linear time", 2000).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace arpent::planning {

/// `marked` has rows x cols cells, row by row; not zero is marked. Squared distances between centres in cells, row by
/// row; kNoneMarked everywhere if nothing is marked. Sides up to 20000 cells.
[[nodiscard]] std::vector<std::int32_t> squared_distances(std::span<const std::uint8_t> marked, int cols, int rows);

inline constexpr std::int32_t kNoneMarked = INT32_MAX;

}  // namespace arpent::planning
