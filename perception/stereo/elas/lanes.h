// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The arithmetic of the narrow-band matcher on the 16 candidates of a pixel, one byte each: `PortableLanes` in plain
// C++, `VectorLanes` in one SSE register (the build asks for AVX2). Both give the same bytes; a test compares them, and
// band_matcher.cpp is written once for either. `NativeLanes` is what this build uses.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "perception/stereo/elas/level.h"

namespace arpent::stereo {

/// Lane of the least value and the value; the first of equals.
struct LeastLane {
  int lane;
  int value;
};

/// Lane of `from` that holds `disparity`, or -1.
inline int find_lane(const Bands& from, int disparity) {
  if (disparity >= from.low && disparity < from.low + kBandWidth) return disparity - from.low;
  if (disparity >= from.high && disparity < from.high + kBandWidth) return disparity - from.high + kBandWidth;
  return -1;
}

/// For each lane of a pixel, where its predecessor on the path holds the same disparity, one less and one more; a value
/// of 0x80 or more means nowhere.
struct alignas(16) Link {
  std::array<std::uint8_t, kLanes> same;
  std::array<std::uint8_t, kLanes> less;
  std::array<std::uint8_t, kLanes> more;
};

inline Link make_link(const Bands& from, const Bands& to) {
  Link link{};
  for (int lane = 0; lane < kLanes; ++lane) {
    const auto i = static_cast<std::size_t>(lane);
    const int d = to.disparity(lane);
    link.same[i] = static_cast<std::uint8_t>(find_lane(from, d));
    link.less[i] = static_cast<std::uint8_t>(find_lane(from, d - 1));
    link.more[i] = static_cast<std::uint8_t>(find_lane(from, d + 1));
  }
  return link;
}

struct PortableLanes {
  using Vector = std::array<std::uint8_t, kLanes>;

  static Vector load(const std::uint8_t* p) {
    Vector v;
    std::copy_n(p, kLanes, v.begin());
    return v;
  }
  static void store(std::uint8_t* p, const Vector& v) { std::copy_n(v.begin(), kLanes, p); }
  static Vector fill(std::uint8_t value) {
    Vector v;
    v.fill(value);
    return v;
  }

  /// a + b, at most 255.
  static Vector add(const Vector& a, const Vector& b) {
    Vector sum;
    for (std::size_t i = 0; i < kLanes; ++i) sum[i] = static_cast<std::uint8_t>(std::min(a[i] + b[i], 255));
    return sum;
  }

  /// Hamming distances of one left descriptor to eight right ones for each band.
  static Vector distances(int left, const int* low, const int* high) {
    Vector v;
    for (std::size_t i = 0; i < kBandWidth; ++i) {
      v[i] = static_cast<std::uint8_t>(std::popcount(static_cast<std::uint32_t>(left ^ low[i])));
      v[i + kBandWidth] = static_cast<std::uint8_t>(std::popcount(static_cast<std::uint32_t>(left ^ high[i])));
    }
    return v;
  }

  /// One step of a path. `previous` holds, for the pixel before, 255 minus (path cost minus its least), so that 0
  /// stands for "no such candidate". Returns the path costs here; `next` is what the following step takes.
  static Vector step(const Vector& previous, const Link& link, const Vector& costs, int step_penalty, int jump_penalty,
                     Vector& next) {
    const auto at = [&](std::uint8_t lane) { return lane < 0x80 ? int{previous[lane]} : 0; };
    Vector path;
    int least = 255;
    for (std::size_t i = 0; i < kLanes; ++i) {
      const int beside = std::max(at(link.less[i]), at(link.more[i])) - step_penalty;
      const int best = std::max({at(link.same[i]), beside, 255 - jump_penalty});
      path[i] = static_cast<std::uint8_t>(std::min(costs[i] + 255 - best, 255));
      least = std::min(least, int{path[i]});
    }
    for (std::size_t i = 0; i < kLanes; ++i) next[i] = static_cast<std::uint8_t>(255 - (path[i] - least));
    return path;
  }

  /// Bit i is set if lane i is below `limit` (1 .. 255).
  static std::uint32_t lanes_below(const Vector& v, int limit) {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kLanes; ++i) bits |= (v[i] < limit ? 1U : 0U) << i;
    return bits;
  }

  static LeastLane least(const Vector& v) {
    const auto it = std::min_element(v.begin(), v.end());
    return {static_cast<int>(it - v.begin()), *it};
  }
};

#ifdef __AVX2__
struct VectorLanes {
  using Vector = __m128i;

  static Vector load(const std::uint8_t* p) { return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p)); }
  static void store(std::uint8_t* p, Vector v) { _mm_storeu_si128(reinterpret_cast<__m128i*>(p), v); }
  static Vector fill(std::uint8_t value) { return _mm_set1_epi8(static_cast<char>(value)); }
  static Vector add(Vector a, Vector b) { return _mm_adds_epu8(a, b); }

  static Vector distances(int left, const int* low, const int* high) {
    const __m256i centre = _mm256_set1_epi32(left);
    const __m256i a = count_bits(_mm256_xor_si256(centre, load_descriptors(low)));
    const __m256i b = count_bits(_mm256_xor_si256(centre, load_descriptors(high)));
    // The packing works within 128-bit halves: a0 b0 a1 b1, put in order as a0 a1 b0 b1.
    const __m256i words = _mm256_permute4x64_epi64(_mm256_packs_epi32(a, b), 0b11011000);
    return _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_extracti128_si256(words, 1));
  }

  static Vector step(Vector previous, const Link& link, Vector costs, int step_penalty, int jump_penalty,
                     Vector& next) {
    const Vector same = _mm_shuffle_epi8(previous, load(link.same.data()));
    const Vector less = _mm_shuffle_epi8(previous, load(link.less.data()));
    const Vector more = _mm_shuffle_epi8(previous, load(link.more.data()));
    const Vector beside = _mm_subs_epu8(_mm_max_epu8(less, more), fill(static_cast<std::uint8_t>(step_penalty)));
    const Vector jump = fill(static_cast<std::uint8_t>(255 - jump_penalty));
    const Vector best = _mm_max_epu8(_mm_max_epu8(beside, jump), same);
    const Vector path = _mm_adds_epu8(costs, _mm_xor_si128(best, fill(255)));
    const Vector pairs = _mm_min_epu8(path, _mm_srli_epi16(path, 8));
    const Vector least = _mm_shuffle_epi8(_mm_minpos_epu16(pairs), _mm_setzero_si128());
    next = _mm_xor_si128(_mm_sub_epi8(path, least), fill(255));
    return path;
  }

  static std::uint32_t lanes_below(Vector v, int limit) {
    const Vector most = fill(static_cast<std::uint8_t>(limit - 1));
    return static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_cmpeq_epi8(_mm_min_epu8(v, most), v)));
  }

  static LeastLane least(Vector v) {
    const std::uint32_t low = static_cast<std::uint32_t>(_mm_cvtsi128_si32(_mm_minpos_epu16(_mm_cvtepu8_epi16(v))));
    const std::uint32_t high = static_cast<std::uint32_t>(
        _mm_cvtsi128_si32(_mm_minpos_epu16(_mm_cvtepu8_epi16(_mm_srli_si128(v, kBandWidth)))));
    const bool second = (high & 0xFFFFU) < (low & 0xFFFFU);
    const std::uint32_t best = second ? high : low;
    return {static_cast<int>(best >> 16U) + (second ? kBandWidth : 0), static_cast<int>(best & 0xFFFFU)};
  }

 private:
  static __m256i load_descriptors(const int* p) { return _mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)); }

  /// Set bits of each 32-bit number, by a table of nibbles.
  static __m256i count_bits(__m256i v) {
    const __m256i table = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,  //
                                           0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
    const __m256i nibble = _mm256_set1_epi8(0x0F);
    const __m256i low = _mm256_shuffle_epi8(table, _mm256_and_si256(v, nibble));
    const __m256i high = _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi16(v, 4), nibble));
    const __m256i bytes = _mm256_add_epi8(low, high);
    return _mm256_madd_epi16(_mm256_maddubs_epi16(bytes, _mm256_set1_epi8(1)), _mm256_set1_epi16(1));
  }
};
using NativeLanes = VectorLanes;
#else
using NativeLanes = PortableLanes;
#endif

}  // namespace arpent::stereo
