// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/clustering.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace arpent::planning {
namespace {

/// Disjoint sets; the representative is the least member.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t of(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = of(a);
    b = of(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  [[nodiscard]] Partition partition() {
    std::vector<std::vector<std::size_t>> members(parent_.size());
    for (std::size_t i = 0; i < parent_.size(); ++i) members[of(i)].push_back(i);
    std::erase_if(members, [](const auto& m) { return m.empty(); });
    return members;
  }

 private:
  std::vector<std::size_t> parent_;
};

double apart_m(const Viewpoint& a, const Viewpoint& b) {
  return (a.pose.position_m() - b.pose.position_m()).norm();
}

struct Pair {
  double distance_m;
  std::size_t a, b;
};

/// All pairs whose drive is at most `max_m`, the shortest first.
std::vector<Pair> near_pairs(std::span<const Viewpoint> viewpoints, const FreeSpace& free_space, double max_m) {
  std::vector<Pair> pairs;
  for (std::size_t a = 0; a < viewpoints.size(); ++a) {
    std::vector<Pose2> poses;
    std::vector<std::size_t> others;
    for (std::size_t b = a + 1; b < viewpoints.size(); ++b) {
      if (apart_m(viewpoints[a], viewpoints[b]) > max_m) continue;  // the drive is no shorter
      poses.push_back(viewpoints[b].pose);
      others.push_back(b);
    }
    if (poses.empty()) continue;
    const auto distances_m = free_space.distances_m(viewpoints[a].pose, poses, max_m);
    for (std::size_t j = 0; j < poses.size(); ++j) {
      if (distances_m[j]) pairs.push_back({*distances_m[j], a, others[j]});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& p, const Pair& q) {
    return std::tuple(p.distance_m, p.a, p.b) < std::tuple(q.distance_m, q.a, q.b);
  });
  return pairs;
}

/// Elements of which every unknown voxel is completed from one of the viewpoints by its own looks, and those that the
/// viewpoints are there for.
std::vector<std::uint32_t> completed_from(std::span<const Viewpoint> viewpoints, const Sight& sight,
                                          double unknown_reach_m) {
  VoxelSet own;  // may need a longer reach
  for (const Viewpoint& viewpoint : viewpoints) own.insert(viewpoint.elements.begin(), viewpoint.elements.end());
  std::vector<std::uint8_t> done(sight.unknowns().size());
  for (const Viewpoint& viewpoint : viewpoints) {
    for (const Look& look : sight.look_at_unknowns(viewpoint.pose, unknown_reach_m)) {
      if (look.share * static_cast<float>(viewpoint.looks) >= 1) done[look.unknown] = 1;
    }
  }
  std::vector<std::uint32_t> elements;
  for (std::uint32_t i = 0; i < sight.elements().size(); ++i) {
    const auto unknowns = sight.unknowns_of(i);
    const bool all = std::all_of(unknowns.begin(), unknowns.end(), [&](std::uint32_t u) { return done[u] != 0; });
    if (all || own.contains(sight.elements()[i].voxel)) elements.push_back(i);
  }
  return elements;
}

/// C_U, the union of what is seen from each viewpoint of the cluster.
std::vector<std::uint32_t> seen_from(std::span<const Viewpoint> viewpoints, const Sight& sight) {
  std::vector<std::uint8_t> seen(sight.elements().size());
  for (const Viewpoint& viewpoint : viewpoints) {
    for (const std::uint32_t i : sight.see_elements(viewpoint.pose)) seen[i] = 1;
  }
  std::vector<std::uint32_t> elements;
  for (std::uint32_t i = 0; i < seen.size(); ++i) {
    if (seen[i] != 0) elements.push_back(i);
  }
  return elements;
}

}  // namespace

Partition cluster_by_single_linkage(std::span<const Viewpoint> viewpoints, const ViewpointParams& params) {
  Sets sets(viewpoints.size());
  std::vector<std::uint8_t> alone(viewpoints.size(), 1);
  for (std::size_t a = 0; a < viewpoints.size(); ++a) {
    for (std::size_t b = a + 1; b < viewpoints.size(); ++b) {
      if (apart_m(viewpoints[a], viewpoints[b]) >= params.d_v_m) continue;
      sets.join(a, b);
      alone[a] = alone[b] = 0;
    }
  }
  for (std::size_t a = 0; a < viewpoints.size(); ++a) {
    if (alone[a] == 0) continue;
    std::size_t nearest = a;
    double nearest_m = params.d_v_max_m;
    for (std::size_t b = 0; b < viewpoints.size(); ++b) {
      if (b == a || apart_m(viewpoints[a], viewpoints[b]) >= nearest_m) continue;
      nearest = b;
      nearest_m = apart_m(viewpoints[a], viewpoints[b]);
    }
    sets.join(a, nearest);
  }
  return sets.partition();
}

Partition cluster_by_drive(std::span<const Viewpoint> viewpoints, const ViewpointParams& params,
                           const FreeSpace& free_space) {
  const std::vector<Pair> pairs = near_pairs(viewpoints, free_space, params.max_diameter_m);
  std::vector<std::vector<std::size_t>> near(viewpoints.size());  // sorted: who may share a cluster with whom
  for (const Pair& pair : pairs) {
    near[pair.a].push_back(pair.b);
    near[pair.b].push_back(pair.a);
  }
  for (auto& list : near) std::sort(list.begin(), list.end());
  std::vector<std::vector<std::size_t>> members(viewpoints.size());
  for (std::size_t i = 0; i < viewpoints.size(); ++i) members[i] = {i};
  Sets sets(viewpoints.size());
  const auto all_near = [&](const std::vector<std::size_t>& ours, const std::vector<std::size_t>& theirs) {
    return std::all_of(ours.begin(), ours.end(), [&](std::size_t i) {
      return std::all_of(theirs.begin(), theirs.end(),
                         [&](std::size_t j) { return std::binary_search(near[i].begin(), near[i].end(), j); });
    });
  };
  for (const Pair& pair : pairs) {
    const std::size_t a = sets.of(pair.a), b = sets.of(pair.b);
    const bool alone = members[a].size() == 1 || members[b].size() == 1;
    if (a == b || pair.distance_m >= (alone ? params.d_v_max_m : params.d_v_m)) continue;
    if (!all_near(members[a], members[b])) continue;
    sets.join(a, b);
    auto& kept = members[std::min(a, b)];
    const auto& gone = members[std::max(a, b)];
    kept.insert(kept.end(), gone.begin(), gone.end());
  }
  return sets.partition();
}

std::vector<Cluster> make_clusters(std::span<const Viewpoint> viewpoints, const Partition& partition,
                                   const Sight& sight, const ViewpointParams& params) {
  std::vector<Cluster> clusters;
  for (const auto& members : partition) {
    Cluster cluster;
    cluster.id = static_cast<int>(clusters.size());
    for (const std::size_t i : members) {
      cluster.viewpoints.push_back(viewpoints[i]);
      cluster.centre_m += viewpoints[i].pose.position_m() / static_cast<double>(members.size());
    }
    const auto counted = params.preset == "thesis" ? seen_from(cluster.viewpoints, sight)
                                                   : completed_from(cluster.viewpoints, sight, params.unknown_reach_m);
    for (const std::uint32_t i : counted) cluster.elements.push_back(sight.elements()[i].voxel);
    cluster.gain = static_cast<double>(counted.size()) / static_cast<double>(sight.elements().size());  // eq. 2.1
    clusters.push_back(std::move(cluster));
  }
  return clusters;
}

}  // namespace arpent::planning
