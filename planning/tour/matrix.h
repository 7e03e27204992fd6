// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The one value type that the tour solvers share: a dense matrix, row = where an arc begins, column = where it ends.
#pragma once

#include <Eigen/Core>

namespace arpent::tour {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

}  // namespace arpent::tour
