// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the calibrations of a drive and of an inertial unit have in common as least squares problems: errors whitened by
// their covariance, a solution with its reduced chi^2, and the covariance of one block of parameters.
#pragma once

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "common/error.h"

namespace arpent::calib {

/// The inverse of the covariance's root. Throws InputError if it is not positive.
template <int N>
Eigen::Matrix<double, N, N> whitening(const Eigen::Matrix<double, N, N>& covariance) {
  const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(covariance);
  if (llt.info() != Eigen::Success) throw InputError("a covariance of the camera's motion is not positive");
  return llt.matrixL().solve(Eigen::Matrix<double, N, N>::Identity());
}

/// Solves with one thread and returns the reduced chi^2. Throws InputError(`failure`) if there is no solution or no
/// error to spare.
inline double solve(ceres::Problem& problem, int most_iterations, double function_tolerance,
                    const std::string& failure) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = most_iterations;
  options.function_tolerance = function_tolerance;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const int dof = problem.NumResiduals() - problem.NumParameters();
  if (!summary.IsSolutionUsable() || dof < 1) throw InputError(failure);
  return 2 * summary.final_cost / dof;
}

/// Covariance of `parameters` for errors of unit variance. Throws InputError(`failure`) if the problem does not
/// determine all of its parameters.
template <std::size_t N>
Eigen::Matrix<double, static_cast<int>(N), static_cast<int>(N)> unit_covariance(ceres::Problem& problem,
                                                                                const std::array<double, N>& parameters,
                                                                                const std::string& failure) {
  ceres::Covariance::Options how;
  how.algorithm_type = ceres::SPARSE_QR;
  how.num_threads = 1;
  ceres::Covariance covariance(how);
  Eigen::Matrix<double, static_cast<int>(N), static_cast<int>(N), Eigen::RowMajor> C;
  const double* block = parameters.data();
  const std::vector<std::pair<const double*, const double*>> blocks{{block, block}};
  if (!covariance.Compute(blocks, &problem) || !covariance.GetCovarianceBlock(block, block, C.data())) {
    throw InputError(failure);
  }
  return C;
}

}  // namespace arpent::calib
