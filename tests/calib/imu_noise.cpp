// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/calib/imu_noise.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <random>

namespace arpent::calib {

std::vector<double> simulate_noise(double white, double bias_instability, double random_walk, double rate_hz,
                                   std::size_t count, std::uint32_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  const auto n = static_cast<int>(count);
  cv::Mat2d spectrum(1, n, cv::Vec2d(0, 0));
  for (int k = 1; k <= n / 2; ++k) {
    const double w = 2 * M_PI * k * rate_hz / n;
    const double density =
        white * white + bias_instability * bias_instability / w + random_walk * random_walk / (w * w);
    const double amplitude = std::sqrt(0.5 * density * rate_hz * n);
    const cv::Vec2d value(amplitude * normal(generator), amplitude * normal(generator));
    spectrum(k) = value;
    spectrum(n - k) = cv::Vec2d(value[0], -value[1]);
  }
  cv::Mat2d signal;
  cv::idft(spectrum, signal, cv::DFT_SCALE);
  std::vector<double> out;
  out.reserve(count);
  for (int i = 0; i < n; ++i) out.push_back(signal(i)[0]);
  return out;
}

}  // namespace arpent::calib
