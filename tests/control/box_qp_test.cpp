// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "control/box_qp.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>
#include <random>

namespace arpent::control {
namespace {

constexpr int kN = 3;
constexpr int kM = 4;
using Qp = BoxQp<kN, kM>;

Qp random_qp(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Qp qp;
  Eigen::Matrix3d A;
  for (double& a : A.reshaped()) a = normal(random);
  qp.H = A * A.transpose() + 0.1 * Eigen::Matrix3d::Identity();
  for (double& a : qp.f.reshaped()) a = 3 * normal(random);
  for (double& a : qp.C.reshaped()) a = normal(random);
  for (int i = 0; i < kM; ++i) {
    qp.low(i) = -std::abs(normal(random)) - 0.05;  // zero is feasible
    qp.high(i) = std::abs(normal(random)) + 0.05;
  }
  return qp;
}

/// All choices of active bounds: each row free, at its lower or at its upper bound.
double best_cost_by_enumeration(const Qp& qp) {
  double best = std::numeric_limits<double>::infinity();
  for (int choice = 0; choice < 81; ++choice) {
    std::vector<std::pair<int, double>> active;
    for (int row = 0, c = choice; row < kM; ++row, c /= 3) {
      if (c % 3 == 1) active.emplace_back(row, qp.low(row));
      if (c % 3 == 2) active.emplace_back(row, qp.high(row));
    }
    if (active.size() > kN) continue;
    const auto n = static_cast<Eigen::Index>(kN + active.size());
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd b(n);
    K.topLeftCorner(kN, kN) = qp.H;
    b.head(kN) = -qp.f;
    for (std::size_t i = 0; i < active.size(); ++i) {
      const auto r = static_cast<Eigen::Index>(kN + i);
      K.row(r).head(kN) = qp.C.row(active[i].first);
      K.col(r).head(kN) = qp.C.row(active[i].first).transpose();
      b(r) = active[i].second;
    }
    const Eigen::VectorXd x = K.fullPivLu().solve(b).head(kN);
    const Eigen::VectorXd Cx = qp.C * x;
    if (((Cx - qp.high).maxCoeff() > 1e-9) || ((qp.low - Cx).maxCoeff() > 1e-9)) continue;
    best = std::min(best, 0.5 * x.dot(qp.H * x) + qp.f.dot(x));
  }
  return best;
}

TEST(BoxQp, TheMinimumIsThatOfAllActiveSets) {
  std::mt19937 random(1);
  for (int i = 0; i < 200; ++i) {
    const Qp qp = random_qp(random);
    const auto solution = solve<kN, kM>(qp, Eigen::Vector3d::Zero(), 3000);
    EXPECT_LT(solution.violation, 1e-4) << i;
    const double cost = 0.5 * solution.x.dot(qp.H * solution.x) + qp.f.dot(solution.x);
    EXPECT_NEAR(cost, best_cost_by_enumeration(qp), 1e-3 * (1 + std::abs(cost))) << i;
  }
}

TEST(BoxQp, WithoutActiveBoundsItIsTheLinearSolution) {
  std::mt19937 random(2);
  Qp qp = random_qp(random);
  qp.low.setConstant(-1e3);
  qp.high.setConstant(1e3);
  EXPECT_TRUE((solve<kN, kM>(qp, Eigen::Vector3d::Zero(), 2000).x).isApprox(-qp.H.inverse() * qp.f, 1e-4));
}

}  // namespace
}  // namespace arpent::control
