// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Noise of a gyro or accelerometer axis with known parameters, made from its power spectrum: N^2 + B^2 / (2 pi f) + K^2
// / (2 pi f)^2 (IEEE Std 952, two-sided). For tests and benches of calib/allan.
#pragma once

#include <cstdint>
#include <vector>

namespace arpent::calib {

[[nodiscard]] std::vector<double> simulate_noise(double white, double bias_instability, double random_walk,
                                                 double rate_hz, std::size_t count, std::uint32_t seed);

}  // namespace arpent::calib
