// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The costs that both matchers share: of a candidate out of view, and of disparities that change from pixel to pixel.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "perception/stereo/elas/census.h"

namespace arpent::stereo {

/// Penalties of the neighbourhood term: for a step of one disparity, and for any jump (on a smooth image; a jump where
/// the image jumps is cheaper).
struct SmoothnessParams {
  int step;
  int jump;
};

/// Cost of a candidate that lies beyond the right image: what two unrelated descriptors differ by on average.
inline constexpr std::uint8_t kOutOfViewCost = kCensusBits / 2;

/// Jump penalty by the difference of grey levels between the two pixels.
using JumpTable = std::array<std::uint8_t, 256>;

inline JumpTable make_jump_table(const SmoothnessParams& p) {
  constexpr int kSmoothGradient = 8;  // grey levels from which on a jump gets cheaper
  constexpr int kOverStep = 3;        // by which it stays dearer than a step
  JumpTable table{};
  for (int g = 0; g < 256; ++g) {
    const int penalty = g > kSmoothGradient ? p.jump * kSmoothGradient / g : p.jump;
    table[static_cast<std::size_t>(g)] = static_cast<std::uint8_t>(std::max(penalty, p.step + kOverStep));
  }
  return table;
}

}  // namespace arpent::stereo
