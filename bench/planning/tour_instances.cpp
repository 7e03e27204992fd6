// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/planning/tour_instances.h"

#include <random>

namespace arpent::bench {

tour::ClusterGraph random_clusters(int clusters, int robots, unsigned seed) {
  std::mt19937_64 random(1000 * seed + static_cast<unsigned>(clusters));
  const auto uniform = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  std::vector<Eigen::Vector2d> points;
  const auto add = [&](double x_m, double y_m) {
    points.emplace_back(x_m, y_m);
    return static_cast<int>(points.size()) - 1;
  };
  std::vector<tour::Cluster> list(static_cast<std::size_t>(clusters));
  double total = 0;
  for (tour::Cluster& cluster : list) {
    const double x_m = uniform(0, 21), y_m = uniform(0, 14);
    const int count = 1 + static_cast<int>(uniform(0, 5));
    for (int i = 0; i < count; ++i) cluster.viewpoints.push_back(add(x_m + uniform(-1, 1), y_m + uniform(-1, 1)));
    cluster.gain = count * uniform(0.2, 1.0);
    total += cluster.gain;
  }
  for (tour::Cluster& cluster : list) cluster.gain /= total;
  std::vector<int> starts;
  for (int robot = 0; robot < robots; ++robot) starts.push_back(add(1.2, 7.0 + 1.2 * (robot - 0.5 * (robots - 1))));
  return {list, starts, [&](int from, int to) {
            return (points[static_cast<std::size_t>(from)] - points[static_cast<std::size_t>(to)]).norm();
          }};
}

std::vector<TourCase> tour_cases() {
  std::vector<TourCase> cases;
  for (const int clusters : {12, 14, 16, 20, 25, 30, 40, 50, 60}) {
    for (const double lambda_tc_1pm : {0.3, 0.7}) {
      for (unsigned seed = 1; seed <= 2; ++seed) cases.push_back({clusters, lambda_tc_1pm, seed});
    }
  }
  return cases;
}

std::vector<double> from_only_start(const tour::Arcs& arcs) {
  return {arcs.from_start.data(), arcs.from_start.data() + arcs.from_start.cols()};
}

}  // namespace arpent::bench
