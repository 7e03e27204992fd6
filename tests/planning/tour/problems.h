// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Random matrices of several structures, and brute force over all permutations: the truth that the tests share.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <random>
#include <vector>

#include "planning/tour/matrix.h"

namespace arpent::tour {

/// kind 0: independent costs; 1: the same, closed under shortest paths; 2: jobs that end elsewhere than they begin (a
/// stacker crane); 3: plane distances with noise that differs by direction.
inline Matrix random_costs(int n, int kind, unsigned seed) {
  std::mt19937_64 random(100 * seed + static_cast<unsigned>(kind));
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53; };
  Matrix begin(n, 2), end(n, 2), cost = Matrix::Zero(n, n);
  for (int i = 0; i < n; ++i) {
    begin.row(i) << uniform(), uniform();
    end.row(i) = begin.row(i);
    if (kind == 2) end.row(i) << uniform(), uniform();
  }
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      if (i != j)
        cost(i, j) = kind < 2 ? uniform() : (end.row(i) - begin.row(j)).norm() + (kind == 3) * 0.2 * uniform();
    }
  }
  for (int k = 0; k < n && kind == 1; ++k) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        if (i != j) cost(i, j) = std::min(cost(i, j), cost(i, k) + cost(k, j));
      }
    }
  }
  return cost;
}

inline std::vector<int> counting(int n) {
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// Least `value` over all orders of 0 .. n - 1.
inline double least_over_permutations(int n, const std::function<double(const std::vector<int>&)>& value) {
  std::vector<int> order = counting(n);
  double least = value(order);
  while (std::next_permutation(order.begin(), order.end())) least = std::min(least, value(order));
  return least;
}

inline bool is_permutation_of(std::vector<int> order, int n) {
  std::sort(order.begin(), order.end());
  return order == counting(n);
}

inline std::vector<double> first_row(const Matrix& matrix) {
  return {matrix.data(), matrix.data() + matrix.cols()};
}

}  // namespace arpent::tour
