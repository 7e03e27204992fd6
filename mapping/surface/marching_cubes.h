// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The case table of marching cubes (Lorensen and Cline 1987), derived rather than copied: on each face of a cell the
// boundary between inside and outside is drawn so that inside corners are cut off one by one, and the pieces are joined
// to loops around the cell. Neighbouring cells see the same face and draw the same line, so the mesh has no cracks.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace arpent::mapping {

/// Corner c of a cell is at ((c & 1), (c >> 1) & 1, (c >> 2) & 1). Edge e joins corners kEdgeCorners[e], the lower
/// first.
inline constexpr std::array<std::array<int, 2>, 12> kEdgeCorners{
    {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3}, {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};

using CellTriangles =
    std::vector<std::array<std::uint8_t, 3>>;  ///< triples of edges, counter-clockwise seen from outside

/// `inside`: bit c is set if corner c is inside the surface.
[[nodiscard]] const CellTriangles& marching_cubes_case(std::uint8_t inside);

}  // namespace arpent::mapping
