// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Random numbers that depend on a seed and a counter alone, whatever the order in which they are drawn.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

namespace arpent::sim {

/// 32 well-mixed bits (multiply-xorshift; the constants pass the avalanche test of tests/sim/noise_test.cpp).
constexpr std::uint32_t mix_bits(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7FEB352DU;
  x ^= x >> 15;
  x *= 0x846CA68BU;
  x ^= x >> 16;
  return x;
}

constexpr std::uint32_t hash_bits(std::uint32_t seed, std::uint32_t counter) {
  return mix_bits(counter + mix_bits(seed + 0x9E3779B9U));
}

/// In [0, 1).
constexpr float uniform_of(std::uint32_t seed, std::uint32_t counter) {
  return static_cast<float>(hash_bits(seed, counter) >> 8) * 0x1.0p-24F;
}

/// Nearly normal, unit deviation, within 3.5: the sum of four uniform 16-bit numbers, which vectorizes (excess kurtosis
/// -0.3).
constexpr float gaussian_of(std::uint32_t seed, std::uint32_t counter) {
  const std::uint32_t a = hash_bits(seed, counter);
  const std::uint32_t b = mix_bits(a ^ 0x68E31DA4U);
  const auto sum = static_cast<int>((a & 0xFFFFU) + (a >> 16) + (b & 0xFFFFU) + (b >> 16));
  // Variance of the sum: 4 (2^32 - 1) / 12.
  return static_cast<float>(sum - 131070) * (1.0F / 37837.2F);
}

/// Smooth noise in space, about 0.4 deviation, one hump a metre.
float smooth_noise(const Eigen::Vector3f& p_m, std::uint32_t seed);

}  // namespace arpent::sim
