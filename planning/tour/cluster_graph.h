// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The directed graph over clusters of viewpoints that tours are planned on (thesis Sect. 2.5.1), for one robot or a
// team: lengths of its arcs, and what the arcs are worth (utility, eq. 2.3) or take (seconds). Lengths come from a
// callback; nothing here knows the map.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "common/config/fields.h"
#include "planning/tour/matrix.h"

namespace arpent::tour {

/// A cluster: numbers of its viewpoints (at least one; as the distance callback knows them) and its gain (eq. 2.1).
struct Cluster {
  std::vector<int> viewpoints;
  double gain = 0;
};

/// Length of the way from one viewpoint (or robot) to another [m]; infinite if there is none. Not negative.
using Distance = std::function<double(int from, int to)>;

/// The arc to cluster V, from a robot or another cluster.
struct Leg {
  double inter_m = 0;  ///< to the entry of V
  double intra_m = 0;  ///< from there through V
  int entry = 0;       ///< viewpoint of V, as an index into its list
};

/// A value per pair of clusters, and per robot and cluster (each robot's start has arcs to all and none from any).
struct Arcs {
  Matrix among;       ///< n x n, row U, column V; the diagonal means nothing
  Matrix from_start;  ///< robots x n
};

class ClusterGraph {
 public:
  /// `starts`: numbers of the robots' poses for `distance`. An arc joins the nearest pair of viewpoints (the exit of U
  /// would depend on where it was entered, which no matrix can say), ties to the first; the path inside V from that
  /// entry is by 3-opt. Throws InputError if a cluster is empty, a gain or a length is negative or not a number.
  ClusterGraph(const std::vector<Cluster>& clusters, const std::vector<int>& starts, const Distance& distance);

  [[nodiscard]] int size() const { return static_cast<int>(clusters_.size()); }
  [[nodiscard]] int robots() const { return static_cast<int>(starts_.size()); }
  [[nodiscard]] const Leg& among(int u, int v) const { return among_[cell(u, v)]; }
  [[nodiscard]] const Leg& from_start(int robot, int v) const { return from_start_[cell(robot, v)]; }

  /// f_UV = g(V) exp(-lambda_tc d(inter) - lambda_ic d(intra)) (eq. 2.3); 0 where there is no way.
  [[nodiscard]] Arcs utilities(double lambda_tc_1pm, double lambda_ic_1pm) const;
  /// Seconds until V is complete, at a constant speed; infinite where there is no way.
  [[nodiscard]] Arcs durations_s(double speed_mps) const;
  [[nodiscard]] std::vector<double> gains() const;
  /// Numbers of the viewpoints along a tour of `robot` through `clusters`, each cluster from its entry on.
  [[nodiscard]] std::vector<int> viewpoints(int robot, const std::vector<int>& clusters) const;

 private:
  [[nodiscard]] std::size_t cell(int row, int v) const {
    return static_cast<std::size_t>(row) * clusters_.size() + static_cast<std::size_t>(v);
  }
  [[nodiscard]] Leg leg(const std::vector<int>& from, int v, const Distance& distance,
                        const std::vector<Matrix>& lengths_m);
  [[nodiscard]] Arcs map(const std::function<double(const Leg&, const Cluster&)>& value) const;

  struct Inside {
    std::vector<int> order;  ///< indices into the cluster's viewpoints
    double length_m = 0;
  };

  std::vector<Cluster> clusters_;
  std::vector<int> starts_;
  std::vector<std::vector<std::optional<Inside>>> inside_;  ///< [cluster][entry], of entries that an arc leads to
  std::vector<Leg> among_, from_start_;
};

/// The penalties of eq. 2.3; the defaults are those of the test arena (thesis Table 5.3).
struct UtilityParams {
  double lambda_tc_1pm = 0.5;
  double lambda_ic_1pm = 0.01;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("lambda_tc_1pm", self.lambda_tc_1pm, "penalty on the way between clusters", config::at_least(0.0));
    visitor.field("lambda_ic_1pm", self.lambda_ic_1pm, "penalty on the way inside a cluster", config::at_least(0.0));
  }
};

}  // namespace arpent::tour
