// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/tour/cluster_graph.h"

#include <cmath>
#include <limits>
#include <string>

#include "common/error.h"
#include "planning/tour/three_opt.h"

namespace arpent::tour {
namespace {

double checked(const Distance& distance, int from, int to) {
  const double length_m = distance(from, to);
  if (!(length_m >= 0)) {
    throw InputError("cluster graph: the distance from " + std::to_string(from) + " to " + std::to_string(to) + " is " +
                     std::to_string(length_m) + " m, must be >= 0");
  }
  return length_m;
}

/// From each viewpoint of the cluster to each.
Matrix lengths_inside(const Cluster& cluster, const Distance& distance) {
  const auto count = static_cast<Eigen::Index>(cluster.viewpoints.size());
  Matrix length(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      length(i, j) = i == j ? 0.0
                            : checked(distance, cluster.viewpoints[static_cast<std::size_t>(i)],
                                      cluster.viewpoints[static_cast<std::size_t>(j)]);
    }
  }
  if (!length.allFinite()) throw InputError("cluster graph: there is no way between two viewpoints of a cluster");
  return length;
}

}  // namespace

ClusterGraph::ClusterGraph(const std::vector<Cluster>& clusters, const std::vector<int>& starts,
                           const Distance& distance)
    : clusters_(clusters), starts_(starts) {
  for (const Cluster& cluster : clusters_) {
    if (cluster.viewpoints.empty()) throw InputError("cluster graph: a cluster has no viewpoints");
    if (!(cluster.gain >= 0) || !std::isfinite(cluster.gain)) {
      throw InputError("cluster graph: a cluster's gain is " + std::to_string(cluster.gain) + ", must be >= 0");
    }
  }
  std::vector<Matrix> lengths_m;
  for (const Cluster& cluster : clusters_) {
    lengths_m.push_back(lengths_inside(cluster, distance));
    inside_.emplace_back(cluster.viewpoints.size());
  }
  for (int u = 0; u < size(); ++u) {
    const std::vector<int>& from = clusters_[static_cast<std::size_t>(u)].viewpoints;
    for (int v = 0; v < size(); ++v) among_.push_back(u == v ? Leg{} : leg(from, v, distance, lengths_m));
  }
  for (const int start : starts_) {
    for (int v = 0; v < size(); ++v) from_start_.push_back(leg({start}, v, distance, lengths_m));
  }
}

/// The nearest pair, and the way inside from there, which is found only once per entry.
Leg ClusterGraph::leg(const std::vector<int>& from, int v, const Distance& distance,
                      const std::vector<Matrix>& lengths_m) {
  const auto cluster = static_cast<std::size_t>(v);
  Leg best;
  best.inter_m = std::numeric_limits<double>::infinity();
  for (const int exit : from) {
    for (std::size_t entry = 0; entry < clusters_[cluster].viewpoints.size(); ++entry) {
      const double length_m = checked(distance, exit, clusters_[cluster].viewpoints[entry]);
      if (length_m < best.inter_m) {
        best.inter_m = length_m;
        best.entry = static_cast<int>(entry);
      }
    }
  }
  std::optional<Inside>& inside = inside_[cluster][static_cast<std::size_t>(best.entry)];
  if (!inside) {
    std::vector<int> order = intra_cluster_path(lengths_m[cluster], best.entry);
    const double length_m = path_length(lengths_m[cluster], order);
    inside = Inside{std::move(order), length_m};
  }
  best.intra_m = inside->length_m;
  return best;
}

Arcs ClusterGraph::map(const std::function<double(const Leg&, const Cluster&)>& value) const {
  Arcs arcs{Matrix::Zero(size(), size()), Matrix::Zero(robots(), size())};
  for (int v = 0; v < size(); ++v) {
    const Cluster& cluster = clusters_[static_cast<std::size_t>(v)];
    for (int u = 0; u < size(); ++u) {
      if (u != v) arcs.among(u, v) = value(among(u, v), cluster);
    }
    for (int robot = 0; robot < robots(); ++robot) arcs.from_start(robot, v) = value(from_start(robot, v), cluster);
  }
  return arcs;
}

Arcs ClusterGraph::utilities(double lambda_tc_1pm, double lambda_ic_1pm) const {
  return map([&](const Leg& leg, const Cluster& v) {
    if (!std::isfinite(leg.inter_m)) return 0.0;
    return v.gain * std::exp(-lambda_tc_1pm * leg.inter_m - lambda_ic_1pm * leg.intra_m);  // eq. 2.3
  });
}

Arcs ClusterGraph::durations_s(double speed_mps) const {
  ARPENT_ASSERT(speed_mps > 0);
  return map([&](const Leg& leg, const Cluster&) { return (leg.inter_m + leg.intra_m) / speed_mps; });
}

std::vector<double> ClusterGraph::gains() const {
  std::vector<double> gains;
  for (const Cluster& cluster : clusters_) gains.push_back(cluster.gain);
  return gains;
}

std::vector<int> ClusterGraph::viewpoints(int robot, const std::vector<int>& clusters) const {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < clusters.size(); ++i) {
    const int v = clusters[i];
    const Leg& leg = i == 0 ? from_start(robot, v) : among(clusters[i - 1], v);
    const auto cluster = static_cast<std::size_t>(v);
    for (const int index : inside_[cluster][static_cast<std::size_t>(leg.entry)]->order) {
      numbers.push_back(clusters_[cluster].viewpoints[static_cast<std::size_t>(index)]);
    }
  }
  return numbers;
}

}  // namespace arpent::tour
