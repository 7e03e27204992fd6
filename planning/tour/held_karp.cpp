// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/held_karp.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "common/error.h"

namespace arpent::tour {

std::vector<int> exact_tour(const Matrix& cost) {
  return exact_weighted_tour(cost, 1.0, std::vector<double>(static_cast<std::size_t>(cost.rows()), 0.0));
}

std::vector<int> exact_weighted_tour(const Matrix& cost, double base, const std::vector<double>& weight) {
  ARPENT_ASSERT(cost.rows() == cost.cols() && weight.size() == static_cast<std::size_t>(cost.rows()) &&
                cost.rows() >= 1 && cost.rows() <= kMostExactNodes);
  const int n = static_cast<int>(cost.rows()) - 1;  // nodes beside node 0; bit i of a set stands for node i + 1
  const auto wide = static_cast<std::size_t>(n);
  const std::uint32_t all = (1U << n) - 1;
  // ahead[set * n + j]: cheapest way from node j + 1, not in the set, through the set and back to node 0.
  std::vector<double> ahead((static_cast<std::size_t>(all) + 1) * wide, std::numeric_limits<double>::infinity());
  const auto at = [&](std::uint32_t set, int j) -> double& { return ahead[set * wide + static_cast<std::size_t>(j)]; };
  std::vector<double> price(static_cast<std::size_t>(all) + 1, base);
  for (std::uint32_t set = 1; set <= all && n > 0; ++set) {
    price[set] = price[set & (set - 1)] + weight[static_cast<std::size_t>(std::countr_zero(set)) + 1];
  }
  const auto next = [&](std::uint32_t set, int from) {
    int best = std::countr_zero(set);
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t rest = set; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const double value = cost(from, k + 1) * price[set] + at(set ^ (1U << k), k);
      if (value < least) {
        least = value;
        best = k;
      }
    }
    return std::pair(best, least);
  };
  for (int j = 0; j < n; ++j) at(0, j) = cost(j + 1, 0);
  for (std::uint32_t set = 1; set < all; ++set) {
    for (std::uint32_t outside = all & ~set; outside != 0; outside &= outside - 1) {
      const int j = std::countr_zero(outside);
      at(set, j) = next(set, j + 1).second;
    }
  }
  std::vector<int> tour = {0};
  for (std::uint32_t set = all; set != 0;) {
    const int k = next(set, tour.back()).first;
    tour.push_back(k + 1);
    set ^= 1U << k;
  }
  return tour;
}

}  // namespace arpent::tour
