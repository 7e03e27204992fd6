// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Patterns of real surfaces: a square tile of numbers with zero mean and unit deviation that repeats without a seam.
// What the kinds have of their models: the spectrum falls with frequency as photographs' do, speckle and pores make the
// histogram uneven, joints and prints make edges. A stereo matcher meets rich kinds, poor ones and repetitive ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace arpent::sim {

/// plain, concrete, asphalt, plaster, mat, wood, carton, metal, bricks, rubber, fabric, stone.
[[nodiscard]] std::vector<std::string> pattern_kinds();

/// side x side numbers, row by row, side a power of two of at least 64. `tile_m` sets the size of what has a size
/// (joints, boards, bricks). The same arguments give the same bytes on every machine. `plain` is all zeros.
[[nodiscard]] std::vector<float> make_pattern(const std::string& kind, int seed, double tile_m, int side);

}  // namespace arpent::sim
