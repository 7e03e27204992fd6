// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/stereo/remap.h"

#include <algorithm>
#include <cmath>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "common/error.h"

namespace arpent::stereo {
namespace {

constexpr int kFractionBits = 5;
constexpr int kOne = 1 << kFractionBits;
constexpr int kHalf = 1 << (2 * kFractionBits - 1);
constexpr int kLargestSide = 2000;
/// Black pixels around the source: one on each side to blend with, and as many on the right as a vector read takes.
constexpr int kPad = 1;
constexpr int kPadRight = 4;
constexpr int kVector = 8;

std::uint8_t sample(const cv::Mat1b& padded, int position) {
  const int u = position & 0xFFFF;
  const int v = position >> 16;
  const std::uint8_t* top = padded.ptr(v >> kFractionBits) + (u >> kFractionBits);
  const std::uint8_t* bottom = top + padded.step;
  const int fu = u & (kOne - 1);
  const int fv = v & (kOne - 1);
  const int upper = top[0] * (kOne - fu) + top[1] * fu;
  const int lower = bottom[0] * (kOne - fu) + bottom[1] * fu;
  return static_cast<std::uint8_t>((upper * (kOne - fv) + lower * fv + kHalf) >> (2 * kFractionBits));
}

/// Pixels [0, n) of a row, n a multiple of eight; returns n.
int sample_vectors([[maybe_unused]] const cv::Mat1b& padded, [[maybe_unused]] const int* positions,
                   [[maybe_unused]] std::uint8_t* out, [[maybe_unused]] int count) {
#ifdef __AVX2__
  const int step = static_cast<int>(padded.step);
  const int* top = reinterpret_cast<const int*>(padded.data);
  const int* bottom = reinterpret_cast<const int*>(padded.data + step);
  const __m256i fraction = _mm256_set1_epi32(kOne - 1);
  const __m256i one = _mm256_set1_epi32(kOne);
  // The first two bytes of each 32-bit word as two 16-bit numbers.
  const __m256i first_two = _mm256_setr_epi8(0, -1, 1, -1, 4, -1, 5, -1, 8, -1, 9, -1, 12, -1, 13, -1,  //
                                             0, -1, 1, -1, 4, -1, 5, -1, 8, -1, 9, -1, 12, -1, 13, -1);
  const auto weights = [&](__m256i f) { return _mm256_or_si256(_mm256_slli_epi32(f, 16), _mm256_sub_epi32(one, f)); };
  int i = 0;
  for (; i + kVector <= count; i += kVector) {
    const __m256i position = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(positions + i));
    const __m256i u = _mm256_and_si256(position, _mm256_set1_epi32(0xFFFF));
    const __m256i v = _mm256_srli_epi32(position, 16);
    const __m256i row = _mm256_mullo_epi32(_mm256_srli_epi32(v, kFractionBits), _mm256_set1_epi32(step));
    const __m256i offset = _mm256_add_epi32(row, _mm256_srli_epi32(u, kFractionBits));
    const __m256i weight_u = weights(_mm256_and_si256(u, fraction));
    const auto blend_row = [&](const int* base) {
      return _mm256_madd_epi16(_mm256_shuffle_epi8(_mm256_i32gather_epi32(base, offset, 1), first_two), weight_u);
    };
    const __m256i both = _mm256_or_si256(blend_row(top), _mm256_slli_epi32(blend_row(bottom), 16));
    const __m256i sum = _mm256_madd_epi16(both, weights(_mm256_and_si256(v, fraction)));
    const __m256i grey = _mm256_srli_epi32(_mm256_add_epi32(sum, _mm256_set1_epi32(kHalf)), 2 * kFractionBits);
    const __m256i words = _mm256_permute4x64_epi64(_mm256_packus_epi32(grey, grey), 0b11011000);
    const __m128i bytes = _mm_packus_epi16(_mm256_castsi256_si128(words), _mm256_castsi256_si128(words));
    _mm_storel_epi64(reinterpret_cast<__m128i*>(out + i), bytes);
  }
  return i;
#else
  return 0;
#endif
}

}  // namespace

Remap::Remap(const cv::Mat1f& u, const cv::Mat1f& v, const cv::Size& source) : source_(source), positions_(u.size()) {
  ARPENT_ASSERT(u.size() == v.size());
  if (source.width > kLargestSide || source.height > kLargestSide) {
    throw InputError("rectification takes images of at most 2000 x 2000 pixels; scale the images or the calibration");
  }
  const auto inside = [](float x, int size) { return x > -1 && x < static_cast<float>(size); };
  const auto fixed = [](float x) { return static_cast<int>(std::lround((x + kPad) * kOne)); };
  for (int row = 0; row < u.rows; ++row) {
    for (int col = 0; col < u.cols; ++col) {
      const bool seen = inside(u(row, col), source.width) && inside(v(row, col), source.height);
      positions_(row, col) = seen ? fixed(v(row, col)) << 16 | fixed(u(row, col)) : 0;
    }
  }
}

cv::Mat1b Remap::apply(const cv::Mat1b& image, bool portable) const {
  ARPENT_ASSERT(image.size() == source_);
  cv::Mat1b padded;
  // One more row than the border: a position that rounds up to the last one still reads the row below.
  cv::copyMakeBorder(image, padded, kPad, kPad + 1, kPad, kPadRight, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::Mat1b result(positions_.size());
  for (int row = 0; row < result.rows; ++row) {
    const int* positions = positions_[row];
    std::uint8_t* out = result[row];
    int i = portable ? 0 : sample_vectors(padded, positions, out, result.cols);
    for (; i < result.cols; ++i) out[i] = sample(padded, positions[i]);
  }
  return result;
}

}  // namespace arpent::stereo
