// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Which incomplete elements hang together. Noise leaves single elements all over a finished map; a frontier is one
// large piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "mapping/tsdf/tsdf_map.h"

namespace arpent::planning {

/// For each element how many there are in its piece, itself included: elements whose voxels touch, also by an edge or a
/// corner, hang together. Unless it is empty, elements without a flag in `counted` do not count: zero for them, and
/// they join no others.
[[nodiscard]] std::vector<std::size_t> piece_sizes(std::span<const mapping::VoxelIndex> elements,
                                                   std::span<const std::uint8_t> counted = {});

}  // namespace arpent::planning
