// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/allan.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <limits>

#include "common/error.h"

namespace arpent::calib {
namespace {

constexpr int kPerDecade = 10;
/// Below, filters in the unit shape the noise; the fit leaves these averaging times out.
constexpr double kLeastTauPeriods = 4;
const double kFlicker = 2 * std::log(2.0) / M_PI;

/// Least squares with non-negative unknowns: the best of all choices of which are zero.
Eigen::Vector3d solve_non_negative(const Eigen::MatrixX3d& A, const Eigen::VectorXd& b) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double least = std::numeric_limits<double>::infinity();
  for (int mask = 1; mask < 8; ++mask) {
    Eigen::MatrixX3d used = A;
    for (int k = 0; k < 3; ++k) {
      if ((mask >> k & 1) == 0) used.col(k).setZero();
    }
    Eigen::Matrix3d H = used.transpose() * used;
    for (int k = 0; k < 3; ++k) {
      if ((mask >> k & 1) == 0) H(k, k) = 1;
    }
    const Eigen::Vector3d x = H.ldlt().solve(used.transpose() * b);
    const double cost = (A * x - b).squaredNorm();
    if (x.minCoeff() >= 0 && cost < least) least = cost, best = x;
  }
  return best;
}

}  // namespace

std::vector<AllanPoint> allan_deviation(const std::vector<double>& signal, double period_s) {
  ARPENT_ASSERT(period_s > 0 && signal.size() >= 20);
  std::vector<double> sums{0};
  double mean = 0;
  for (const double x : signal) mean += x / static_cast<double>(signal.size());
  for (const double x : signal) sums.push_back(sums.back() + (x - mean));
  std::vector<AllanPoint> points;
  std::size_t last = 0;
  for (int step = 0;; ++step) {
    const auto m = static_cast<std::size_t>(std::lround(std::pow(10.0, static_cast<double>(step) / kPerDecade)));
    if (m > signal.size() / 9) return points;
    if (m == last) continue;
    last = m;
    double squares = 0;
    const std::size_t count = sums.size() - 2 * m;
    for (std::size_t i = 0; i < count; ++i) {
      const double d = sums[i + 2 * m] - 2 * sums[i + m] + sums[i];
      squares += d * d;
    }
    const auto length = static_cast<double>(m);
    points.push_back({length * period_s, std::sqrt(squares / (2 * length * length * static_cast<double>(count)))});
  }
}

AxisNoise fit_noise(const std::vector<AllanPoint>& points, double duration_s) {
  ARPENT_ASSERT(points.size() >= 5);
  std::vector<AllanPoint> used;
  for (const AllanPoint& p : points) {
    if (p.tau_s > (kLeastTauPeriods - 0.5) * points.front().tau_s && p.deviation > 0) used.push_back(p);
  }
  AxisNoise noise;
  if (used.size() < 5) return noise;
  // Relative errors, by the model of the round before (first by the measurement).
  std::vector<double> scale;
  for (const AllanPoint& p : used) scale.push_back(p.deviation * p.deviation);
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  for (int round = 0; round < 10; ++round) {
    Eigen::MatrixX3d A(static_cast<Eigen::Index>(used.size()), 3);
    Eigen::VectorXd b(A.rows());
    for (std::size_t i = 0; i < used.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const double tau_s = used[i].tau_s, weight = std::sqrt(duration_s / tau_s) / scale[i];
      A.row(row) << weight / tau_s, weight * kFlicker, weight * tau_s / 3;
      b[row] = weight * used[i].deviation * used[i].deviation;
    }
    const Eigen::Vector3d unit = A.colwise().norm();
    x = solve_non_negative(A * unit.cwiseInverse().asDiagonal(), b).cwiseQuotient(unit);
    for (std::size_t i = 0; i < used.size(); ++i) {
      scale[i] = x[0] / used[i].tau_s + kFlicker * x[1] + x[2] * used[i].tau_s / 3;
    }
  }
  noise.white = std::sqrt(x[0]);
  noise.bias_instability = std::sqrt(x[1]);
  noise.random_walk = std::sqrt(x[2]);
  noise.random_walk_bound = used.back().deviation * std::sqrt(3 / used.back().tau_s);
  return noise;
}

}  // namespace arpent::calib
