// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/allan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/calib/imu_noise.h"

namespace arpent::calib {
namespace {

TEST(Allan, DeviationOfAShortRecordIsWhatPlainSumsGive) {
  std::vector<double> signal;
  for (int i = 0; i < 90; ++i) signal.push_back(std::sin(1.7 * i) + 0.01 * i);
  for (const AllanPoint& point : allan_deviation(signal, 0.5)) {
    const auto m = static_cast<std::size_t>(std::lround(point.tau_s / 0.5));
    double squares = 0, count = 0;
    for (std::size_t i = 0; i + 2 * m <= signal.size(); ++i) {
      double first = 0, second = 0;
      for (std::size_t k = 0; k < m; ++k) first += signal[i + k], second += signal[i + m + k];
      squares += std::pow((second - first) / static_cast<double>(m), 2);
      count += 1;
    }
    EXPECT_NEAR(point.deviation, std::sqrt(squares / (2 * count)), 1e-12) << point.tau_s;
  }
}

TEST(Allan, WhiteNoiseAloneIsFoundAndNothingElse) {
  const auto signal = simulate_noise(2e-3, 0, 0, 100, 360000, 1);
  const AxisNoise noise = fit_noise(allan_deviation(signal, 0.01), 3600);
  EXPECT_NEAR(noise.white, 2e-3, 0.02 * 2e-3);
  EXPECT_LT(noise.bias_instability, 1.5e-4);
  EXPECT_LT(noise.random_walk, 1e-5);
}

TEST(Allan, ThreeNoisesAreToldApart) {
  // Lines meet where N / sqrt(tau) = 0.664 B (tau = 9 s) and K sqrt(tau / 3) = 0.664 B (tau = 1324 s).
  const double N = 2e-3, B = 1e-3, K = 2e-5;
  const auto signal = simulate_noise(N, B, K, 100, 1080000, 2);
  const AxisNoise noise = fit_noise(allan_deviation(signal, 0.01), 10800);
  EXPECT_NEAR(noise.white / N, 1, 0.03);
  EXPECT_NEAR(noise.bias_instability / B, 1, 0.2);
  EXPECT_LT(noise.random_walk, noise.random_walk_bound);
  EXPECT_NEAR(noise.random_walk / K, 1, 1.0);
}

}  // namespace
}  // namespace arpent::calib
