// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// From the sums of path costs to disparities: the least of a pixel's candidates, refined between its neighbours, and
// kept only if no other pixel has the better claim to the same pixel of the right image.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <vector>

#include "perception/stereo/elas/lanes.h"

namespace arpent::stereo {

/// The winning candidate of each pixel of a row. A list per member: what follows runs over whole vectors (bench
/// `elas`).
struct Winners {
  std::vector<std::int32_t> disparity_px;  ///< -1: no candidate within the right image
  std::vector<std::int32_t> cost;
  std::vector<std::int32_t> less;   ///< cost one disparity less; `cost` where that is no candidate
  std::vector<std::int32_t> more;   ///< and one more
  std::vector<std::int32_t> clear;  ///< 0: a rival is about as good; otherwise 1

  explicit Winners(int cols)
      : disparity_px(static_cast<std::size_t>(cols)),
        cost(disparity_px.size()),
        less(disparity_px.size()),
        more(disparity_px.size()),
        clear(disparity_px.size()) {}

  void set(int u, int disparity, int at, int one_less, int one_more, bool rival) {
    const auto i = static_cast<std::size_t>(u);
    disparity_px[i] = disparity;
    cost[i] = at;
    less[i] = one_less;
    more[i] = one_more;
    clear[i] = rival ? 0 : 1;
  }
  void set_none(int u) { set(u, -1, 0, 0, 0, true); }
};

/// A disparity elsewhere whose cost lies below this makes the winner ambiguous.
inline int rival_limit(int winning_cost) {
  constexpr int kFloor = 20;
  constexpr int kShare = 5;
  return std::min(winning_cost + (winning_cost + kFloor) / kShare, 255);
}

/// Refines each minimum with the costs beside it (equiangular fit: two lines of one slope, as Hamming distances rise
/// linearly). Sharpness is that slope; 0: not refined, or ambiguous.
inline void refine_row(const Winners& winners, std::uint16_t* __restrict px128, std::uint8_t* __restrict sharpness) {
  const std::int32_t* disparity_px = winners.disparity_px.data();
  const std::int32_t* cost = winners.cost.data();
  const std::int32_t* less = winners.less.data();
  const std::int32_t* more = winners.more.data();
  const std::int32_t* clear = winners.clear.data();
  const auto cols = static_cast<int>(winners.cost.size());
  for (int u = 0; u < cols; ++u) {
    const int rise = std::max(std::max(less[u], more[u]) - cost[u], 0);
    const int lean = rise > 0 ? less[u] - more[u] : 0;
    const float offset = 0.5F * static_cast<float>(lean) / static_cast<float>(std::max(rise, 1));
    const float px = static_cast<float>(disparity_px[u]) + offset;
    px128[u] = static_cast<std::uint16_t>(static_cast<int>(px * kUnitsPerPixel + 0.5F));
    sharpness[u] = static_cast<std::uint8_t>(std::min(rise, 255) * clear[u]);
  }
}

/// Takes out those pixels of a row whose partner in the right image has a better claim by a pixel of another disparity.
inline void settle_claims(const Winners& winners, std::uint16_t* px128, std::uint8_t* sharpness) {
  // Cost, then disparity, in one number: the best claim is the least, without a branch.
  constexpr std::int32_t kUnclaimed = std::numeric_limits<std::int32_t>::max();
  constexpr int kDisparityBits = 16;
  const auto cols = static_cast<int>(winners.cost.size());
  std::vector<std::int32_t> claims(winners.cost.size(), kUnclaimed);
  const auto claim_of = [&](int u, int disparity_px) -> std::int32_t& {
    return claims[static_cast<std::size_t>(u - disparity_px)];
  };
  for (int u = 0; u < cols; ++u) {
    const auto i = static_cast<std::size_t>(u);
    if (winners.disparity_px[i] < 0) continue;
    std::int32_t& claim = claim_of(u, winners.disparity_px[i]);
    claim = std::min(claim, winners.cost[i] << kDisparityBits | winners.disparity_px[i]);
  }
  for (int u = 0; u < cols; ++u) {
    const int disparity_px = winners.disparity_px[static_cast<std::size_t>(u)];
    const int claimed =
        disparity_px < 0 ? 1 << kDisparityBits : claim_of(u, disparity_px) & ((1 << kDisparityBits) - 1);
    const bool lost = std::abs(claimed - disparity_px) > 1;
    px128[u] = lost ? kMissing : px128[u];
    sharpness[u] = lost ? std::uint8_t{0} : sharpness[u];
  }
}

/// Writes the winners of one row whose claims on the right image hold; others are missing.
inline void settle_row(const Winners& winners, std::uint16_t* px128, std::uint8_t* sharpness) {
  refine_row(winners, px128, sharpness);
  settle_claims(winners, px128, sharpness);
}

/// A lane's neighbours in disparity: the lanes beside it, or itself at the end of a band.
struct Beside {
  std::uint8_t less;
  std::uint8_t more;
  std::uint16_t mask;  ///< the lane and its neighbours
};

constexpr std::array<Beside, kLanes> make_beside(bool contiguous) {
  std::array<Beside, kLanes> table{};
  for (int lane = 0; lane < kLanes; ++lane) {
    const bool at_start = lane == 0 || (lane == kBandWidth && !contiguous);
    const bool at_end = lane == kLanes - 1 || (lane == kBandWidth - 1 && !contiguous);
    const unsigned less = at_start ? 0U : 1U << (lane - 1);
    const unsigned more = at_end ? 0U : 1U << (lane + 1);
    // At either end nothing is refined: both are the lane itself.
    const bool inside = !at_start && !at_end;
    table[static_cast<std::size_t>(lane)] = {static_cast<std::uint8_t>(inside ? lane - 1 : lane),
                                             static_cast<std::uint8_t>(inside ? lane + 1 : lane),
                                             static_cast<std::uint16_t>(less | 1U << lane | more)};
  }
  return table;
}
inline constexpr std::array<std::array<Beside, kLanes>, 2> kBeside{make_beside(false), make_beside(true)};

/// Winner of one pixel among its candidates within the right image.
template <class L>
void choose_winner(const std::uint8_t* sums, const Bands& bands, int u, Winners& winners) {
  LeastLane least{-1, 0x10000};
  std::uint32_t out_of_view = 0;
  if (u >= bands.high + kBandWidth - 1) {
    least = L::least(L::load(sums));
  } else {
    for (int i = 0; i < kLanes; ++i) {
      if (bands.disparity(i) > u) {
        out_of_view |= 1U << i;
      } else if (sums[i] < least.value) {
        least = {i, sums[i]};
      }
    }
    if (least.lane < 0) return winners.set_none(u);
  }
  const bool contiguous = bands.high == bands.low + kBandWidth;
  const Beside& beside = kBeside[contiguous ? 1 : 0][static_cast<std::size_t>(least.lane)];
  const std::uint32_t below = L::lanes_below(L::load(sums), rival_limit(least.value));
  const bool rival = (below & ~std::uint32_t{beside.mask} & ~out_of_view) != 0;
  winners.set(u, bands.disparity(least.lane), least.value, sums[beside.less], sums[beside.more], rival);
}

/// One row: `sums` holds 16 per pixel, `bands` one entry per block of columns.
template <class L>
void choose_winners(const std::uint8_t* sums, const Bands* bands, int cols, std::uint16_t* px128,
                    std::uint8_t* sharpness) {
  Winners winners(cols);
  for (int u = 0; u < cols; ++u) choose_winner<L>(sums + kLanes * u, bands[u / kBlock], u, winners);
  settle_row(winners, px128, sharpness);
}

}  // namespace arpent::stereo
