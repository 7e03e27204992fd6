// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A small convex quadratic program with bounds: minimise 1/2 x'Hx + f'x over l <= Cx <= h, by the alternating direction
// method of multipliers (Stellato et al., "OSQP: an operator splitting solver for quadratic programs", 2020, alg. 1). A
// fixed number of steps takes a fixed time; sizes are compile-time, nothing is allocated.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace arpent::control {

template <int kVariables, int kRows>
struct BoxQp {
  Eigen::Matrix<double, kVariables, kVariables> H;
  Eigen::Matrix<double, kVariables, 1> f;
  Eigen::Matrix<double, kRows, kVariables> C;
  Eigen::Matrix<double, kRows, 1> low, high;
};

template <int kVariables, int kRows>
struct QpSolution {
  Eigen::Matrix<double, kVariables, 1> x;
  /// Largest distance of Cx from its bounds; the caller judges.
  double violation = 0;
};

/// `start`: a guess of x. H must be positive definite.
template <int kVariables, int kRows>
QpSolution<kVariables, kRows> solve(const BoxQp<kVariables, kRows>& qp,
                                    const Eigen::Matrix<double, kVariables, 1>& start, int steps) {
  using Variables = Eigen::Matrix<double, kVariables, 1>;
  using Rows = Eigen::Matrix<double, kRows, 1>;
  constexpr double kOverRelaxation = 1.6;
  // The penalty in proportion to the problem's own scale.
  const double rho = 0.1 * qp.H.trace() / kVariables;
  const double rho_sigma = 1e-6 * rho;
  const Eigen::LLT<Eigen::Matrix<double, kVariables, kVariables>> K(
      qp.H + rho_sigma * Eigen::Matrix<double, kVariables, kVariables>::Identity() + rho * qp.C.transpose() * qp.C);
  Variables x = start;
  Rows z = (qp.C * x).cwiseMax(qp.low).cwiseMin(qp.high);
  Rows y = Rows::Zero();
  for (int i = 0; i < steps; ++i) {
    const Variables x_new = K.solve(rho_sigma * x - qp.f + qp.C.transpose() * (rho * z - y));
    const Rows mixed = kOverRelaxation * (qp.C * x_new) + (1 - kOverRelaxation) * z;
    z = (mixed + y / rho).cwiseMax(qp.low).cwiseMin(qp.high);
    y += rho * (mixed - z);
    x = x_new;
  }
  const Rows Cx = qp.C * x;
  return {x, std::max((qp.low - Cx).maxCoeff(), (Cx - qp.high).maxCoeff())};
}

}  // namespace arpent::control
