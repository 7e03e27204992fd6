// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The noise of an inertial unit from readings at rest, by the Allan variance (El-Sheimy et al. 2008; IEEE Std 952):
// white noise, bias instability and random walk of one axis.
#pragma once

#include <optional>
#include <vector>

namespace arpent::calib {

struct AllanPoint {
  double tau_s = 0;
  double deviation = 0;  ///< in the signal's unit
};

/// Overlapping Allan deviation at about ten averaging times per decade, from `period_s` to a ninth of the record.
[[nodiscard]] std::vector<AllanPoint> allan_deviation(const std::vector<double>& signal, double period_s);

/// Signal's unit u: white noise [u / sqrt(Hz)], bias instability [u], random walk [u / s / sqrt(Hz)].
struct AxisNoise {
  double white = 0;
  double bias_instability = 0;
  double random_walk = 0;
  /// Largest random walk that the longest averaging time allows; what to use where `random_walk` is not seen (0).
  double random_walk_bound = 0;
};

/// Fits sigma^2(tau) = N^2 / tau + (2 ln 2 / pi) B^2 + K^2 tau / 3 with N, B, K >= 0, each point weighted by the number
/// of independent averages in a record of `duration_s`.
[[nodiscard]] AxisNoise fit_noise(const std::vector<AllanPoint>& points, double duration_s);

}  // namespace arpent::calib
