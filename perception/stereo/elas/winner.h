// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// From the sums of path costs to disparities: the least of a pixel's candidates, refined between its neighbours, and
// kept only if no other pixel has the better claim to the same pixel of the right image.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

#include "perception/stereo/elas/lanes.h"

namespace arpent::stereo {

struct Winner {
  std::int16_t disparity_px = -1;  ///< whole pixels, -1: no candidate within the right image
  std::uint16_t cost = 0xFFFF;
  std::uint16_t px128 = kMissing;  ///< refined
  std::uint8_t sharpness = 0;      ///< 0: not refined, or a rival is about as good
};

/// A disparity elsewhere whose cost lies below this makes the winner ambiguous.
inline int rival_limit(int winning_cost) {
  constexpr int kFloor = 20;
  constexpr int kShare = 5;
  return std::min(winning_cost + (winning_cost + kFloor) / kShare, 255);
}

/// Refines the minimum `cost` at `disparity_px` with the costs one disparity less and more (equiangular fit: two lines
/// of one slope, as Hamming distances rise linearly).
inline void refine(Winner& winner, int less, int more) {
  const int rise = std::max(less, more) - winner.cost;
  if (rise <= 0) return;
  const float offset = 0.5F * static_cast<float>(less - more) / static_cast<float>(rise);
  const float px = static_cast<float>(winner.disparity_px) + offset;
  winner.px128 = static_cast<std::uint16_t>(std::max(px * kUnitsPerPixel + 0.5F, 0.0F));
  winner.sharpness = static_cast<std::uint8_t>(std::min(rise, 255));
}

/// Keeps those pixels of a row whose partner in the right image has no better claim by a pixel of another disparity.
class RightClaims {
 public:
  explicit RightClaims(int cols) : claims_(static_cast<std::size_t>(cols)) {}

  void claim(int u, const Winner& w) {
    Claim& c = claims_[static_cast<std::size_t>(u - w.disparity_px)];
    if (w.cost < c.cost) c = {w.disparity_px, w.cost};
  }
  [[nodiscard]] bool agrees(int u, const Winner& w) const {
    const Claim& c = claims_[static_cast<std::size_t>(u - w.disparity_px)];
    return std::abs(c.disparity_px - w.disparity_px) <= 1;
  }

 private:
  struct Claim {
    std::int16_t disparity_px = -1;
    std::uint16_t cost = 0xFFFF;
  };
  std::vector<Claim> claims_;
};

/// Winner of one pixel among its candidates within the right image.
template <class L>
Winner choose_winner(const std::uint8_t* sums, const Bands& bands, int u) {
  Winner winner;
  int lane = -1;
  std::uint32_t out_of_view = 0;
  if (u >= bands.high + kBandWidth - 1) {
    const LeastLane least = L::least(L::load(sums));
    lane = least.lane;
    winner.cost = static_cast<std::uint16_t>(least.value);
  } else {
    for (int i = 0; i < kLanes; ++i) {
      if (bands.disparity(i) > u) {
        out_of_view |= 1U << i;
        continue;
      }
      if (sums[i] >= winner.cost) continue;
      lane = i;
      winner.cost = sums[i];
    }
    if (lane < 0) return winner;
  }
  winner.disparity_px = static_cast<std::int16_t>(bands.disparity(lane));
  winner.px128 = static_cast<std::uint16_t>(winner.disparity_px * static_cast<int>(kUnitsPerPixel));
  const bool contiguous = bands.high == bands.low + kBandWidth;
  const bool at_start = lane == 0 || (lane == kBandWidth && !contiguous);
  const bool at_end = lane == kLanes - 1 || (lane == kBandWidth - 1 && !contiguous);
  if (!at_start && !at_end) refine(winner, sums[lane - 1], sums[lane + 1]);
  const std::uint32_t beside = (at_start ? 0U : 1U << (lane - 1)) | 1U << lane | (at_end ? 0U : 1U << (lane + 1));
  if ((L::lanes_below(L::load(sums), rival_limit(winner.cost)) & ~beside & ~out_of_view) != 0) winner.sharpness = 0;
  return winner;
}

/// Writes the winners of one row (`winners.size()` pixels) whose claims on the right image hold; others are missing.
inline void settle_row(const std::vector<Winner>& winners, std::uint16_t* px128, std::uint8_t* sharpness) {
  const auto cols = static_cast<int>(winners.size());
  RightClaims claims(cols);
  const auto at = [&](int u) -> const Winner& { return winners[static_cast<std::size_t>(u)]; };
  for (int u = 0; u < cols; ++u) {
    if (at(u).disparity_px >= 0) claims.claim(u, at(u));
  }
  for (int u = 0; u < cols; ++u) {
    const bool good = at(u).disparity_px >= 0 && claims.agrees(u, at(u));
    px128[u] = good ? at(u).px128 : kMissing;
    sharpness[u] = good ? at(u).sharpness : std::uint8_t{0};
  }
}

/// One row: `sums` holds 16 per pixel, `bands` one entry per block of columns.
template <class L>
void choose_winners(const std::uint8_t* sums, const Bands* bands, int cols, std::uint16_t* px128,
                    std::uint8_t* sharpness) {
  std::vector<Winner> winners(static_cast<std::size_t>(cols));
  for (int u = 0; u < cols; ++u) {
    winners[static_cast<std::size_t>(u)] = choose_winner<L>(sums + kLanes * u, bands[u / kBlock], u);
  }
  settle_row(winners, px128, sharpness);
}

}  // namespace arpent::stereo
