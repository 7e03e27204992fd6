// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What drives between robots and clusters of viewpoints cost, for the tours of one robot and of a team: lengths of the
// ways over the ground, by number of viewpoint as planning/tour wants them, and the times of visits. It orders nothing.
#pragma once

#include <span>
#include <vector>

#include "planning/local/ground.h"
#include "planning/tour/cluster_graph.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

struct VisitTimes {
  double speed_mps = 0.5;
  double turn_rate_radps = 1.0;
  double visit_s = 0;   ///< at each viewpoint, at least
  double looks_hz = 5;  ///< depth images per second
};

/// From where a robot's new tour begins, and how long it takes until it can.
struct RobotPlace {
  Pose2 from;
  double busy_s = 0;
};

/// The same ground in cells of twice the size, each as bad as the worst of its four: for prices.
[[nodiscard]] Ground halve(const Ground& ground);

/// Viewpoints by number, cluster after cluster, then the robots; and the lengths of drives between them. One search
/// from each robot and one from the middle of each cluster, on cells of twice the ground's size.
class Roads {
 public:
  /// No cluster may be empty.
  Roads(const Ground& ground, const std::vector<Cluster>& clusters, std::span<const RobotPlace> robots);

  /// Length of the drive to viewpoint `to` [m], infinite if there is none: from a robot as searched (on cells: it may
  /// be a little less than the straight line), from a viewpoint by the triangle's inequality.
  [[nodiscard]] double operator()(int from, int to) const;
  [[nodiscard]] double straight_m(int from, int to) const;

  [[nodiscard]] const std::vector<Viewpoint>& viewpoints() const { return viewpoints_; }
  [[nodiscard]] const std::vector<tour::Cluster>& nodes() const { return nodes_; }
  [[nodiscard]] const std::vector<int>& starts() const { return starts_; }

 private:
  struct Search {
    Eigen::Vector2d p_m;
    std::vector<double> length_m;  ///< to each viewpoint
  };

  void search(const Ground& coarse, const Eigen::Vector2d& p_m);
  [[nodiscard]] Eigen::Vector2d position_m(std::size_t number) const;

  std::vector<Viewpoint> viewpoints_;
  std::vector<std::size_t> source_;  ///< of each viewpoint, into searches_
  std::vector<tour::Cluster> nodes_;
  std::vector<int> starts_;
  std::vector<Search> searches_;  ///< from the robots, then from the clusters
};

/// Seconds until a cluster is complete: the drive, the stays at its viewpoints, and what a robot is still busy with.
[[nodiscard]] tour::Arcs visit_durations_s(const tour::ClusterGraph& graph, const std::vector<Cluster>& clusters,
                                           std::span<const RobotPlace> robots, const VisitTimes& times);

}  // namespace arpent::planning
