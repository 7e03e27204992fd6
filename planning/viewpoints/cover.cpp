// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/viewpoints/cover.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>

#include "planning/viewpoints/generation.h"

namespace arpent::planning {
namespace {

using std::numbers::pi;

struct Round {
  std::size_t poses_per_element;  ///< free ones that an element may ask for
  double widest_rad;              ///< from the direction from which it wants to be seen
  std::size_t least_worth;
  double share_of_minimum;  ///< of min_viewpoint_m2, that a viewpoint has to complete
  bool all_looks;
};
/// Most elements are served by the first round, from the poses that serve many.
constexpr std::array<Round, 3> kRounds = {{{1, pi / 3, 8, 1, false}, {3, pi / 3, 3, 0.25, false}, {6, pi, 1, 0, true}}};
/// So many times min_viewpoint_m2 are worth a tour of their own; where there is less, smaller viewpoints come along:
/// one at a time they would be driven to to and fro.
constexpr double kTourMinima = 10;
/// Elements near the floor are measured from close by only: so near may the camera go.
constexpr double kNearestM = 0.7;

/// A pose of the lattice, by counts of its steps.
struct Node {
  int x = 0, y = 0, heading = 0;
  friend auto operator<=>(const Node&, const Node&) = default;
};

class Candidates {
 public:
  Candidates(const Sight& sight, const ViewpointParams& params) : sight_(sight), params_(params) {}

  /// Free and reachable poses, each asked for by at least one element of `left`; a fixed order.
  std::vector<Pose2> find(const std::vector<std::uint32_t>& left, const Round& round, const FreeSpace& free_space,
                          const Pose2& robot) {
    std::vector<std::vector<Node>> asked;
    std::map<Node, int> votes;
    for (const std::uint32_t element : left) {
      asked.push_back(nodes_around(element, round));
      for (const Node& node : asked.back()) ++votes[node];
    }
    std::map<Node, bool> free;
    std::map<Node, int> chosen;
    for (auto& nodes : asked) {
      std::stable_sort(nodes.begin(), nodes.end(), [&](const Node& a, const Node& b) { return votes[a] > votes[b]; });
      std::size_t found = 0;
      for (std::size_t i = 0; i < nodes.size() && found < round.poses_per_element; ++i) {
        const auto [entry, fresh] = free.try_emplace(nodes[i]);
        if (fresh) entry->second = free_space.is_free(pose_of(nodes[i]));
        if (!entry->second) continue;
        ++found;
        ++chosen[nodes[i]];
      }
    }
    std::vector<Pose2> poses;
    for (const auto& entry : chosen) poses.push_back(pose_of(entry.first));
    const auto distances_m = free_space.distances_m(robot, poses);
    std::vector<Pose2> reachable;
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (distances_m[i]) reachable.push_back(poses[i]);
    }
    return reachable;
  }

 private:
  [[nodiscard]] Pose2 pose_of(const Node& node) const {
    return {node.x * params_.lattice_m, node.y * params_.lattice_m,
            wrap_angle(2 * pi * node.heading / params_.headings)};
  }

  /// Poses from which the element's unknown voxels would be completed if nothing were in between.
  [[nodiscard]] std::vector<Node> nodes_around(std::uint32_t index, const Round& round) const {
    const mapping::IncompleteElement& element = sight_.elements()[index];
    const LevelCamera& camera = sight_.camera();
    // A voxel more than the element itself needs: its unknown neighbour may be above it.
    const double view_m = stand_off_m(camera, kNearestM, element.centre_m.z()) + sight_.voxel_m();
    const double least_m = std::max(view_m, params_.delta_pose_m);
    std::vector<Node> nodes;
    const bool steep = is_steep(element, params_.steep_angle_deg);
    const double first = std::atan2(element.direction.y(), element.direction.x());
    for (const double azimuth : azimuths_around(element, params_.ring)) {
      if (!steep && std::abs(wrap_angle(azimuth - first)) > round.widest_rad + 1e-9) continue;
      for (const double distance_m : {view_m, least_m, least_m + kFartherM}) {
        const Node node = node_of(look_at(camera, element.centre_m, azimuth, distance_m));
        if (would_complete(index, pose_of(node), round)) nodes.push_back(node);
      }
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    return nodes;
  }

  [[nodiscard]] bool would_complete(std::uint32_t element, const Pose2& pose, const Round& round) const {
    const CameraView view(sight_.camera(), pose);
    const int looks = round.all_looks ? params_.max_looks : params_.looks;
    const auto unknowns = sight_.unknowns_of(element);
    return std::all_of(unknowns.begin(), unknowns.end(), [&](std::uint32_t u) {
      const UnknownVoxel& unknown = sight_.unknowns()[u];
      return view.contains(unknown.centre_m) && sight_.measures(view, unknown) &&
             looks * Sight::share_of_look(view, unknown) >= 1;
    });
  }

  [[nodiscard]] Node node_of(const Pose2& pose) const {
    const auto steps = [](double value, double step) { return static_cast<int>(std::lround(value / step)); };
    const int heading = steps(pose.yaw_rad, 2 * pi / params_.headings);
    return {steps(pose.x_m, params_.lattice_m), steps(pose.y_m, params_.lattice_m),
            (heading + params_.headings) % params_.headings};
  }

  const Sight& sight_;
  const ViewpointParams& params_;
};

/// Which unknown voxels still have to be completed: those of the elements left.
std::vector<std::uint8_t> wanted_of(const Cover& cover, const Sight& sight) {
  std::vector<std::uint8_t> wanted(sight.unknowns().size());
  for (const std::uint32_t element : cover.left) {
    for (const std::uint32_t u : sight.unknowns_of(element)) wanted[u] = sight.is_given_up(element) ? wanted[u] : 1;
  }
  return wanted;
}

struct Offer {
  std::vector<std::uint32_t> unknowns;
  int looks = 1;
};

/// What of the wanted the pose completes.
Offer offer_of(const Sight& sight, const Pose2& pose, const Effort& effort, const std::vector<std::uint8_t>& wanted) {
  Offer offer;
  float least = std::numeric_limits<float>::infinity();
  for (const Look& look : sight.look_at_unknowns(pose, effort.unknown_reach_m, wanted)) {
    if (look.share * static_cast<float>(effort.looks) < 1) continue;
    offer.unknowns.push_back(look.unknown);
    least = std::min(least, look.share);
  }
  offer.looks = std::clamp(static_cast<int>(std::ceil(1 / least)), 1, effort.looks);
  return offer;
}

/// Greedy set cover. Offers only shrink, so one whose size is up to date and still the largest is the best (lazy
/// evaluation: Minoux 1978). Returns the chosen poses, by index, with what each completes.
std::vector<std::pair<std::size_t, Offer>> choose(const Sight& sight, const std::vector<Pose2>& poses,
                                                  const Effort& effort, std::vector<std::uint8_t> wanted) {
  std::vector<Offer> offers;
  using Entry = std::pair<std::size_t, std::ptrdiff_t>;  // size, and minus the index: ties go to the first pose
  std::priority_queue<Entry> queue;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    offers.push_back(offer_of(sight, poses[i], effort, wanted));
    queue.emplace(offers[i].unknowns.size(), -static_cast<std::ptrdiff_t>(i));
  }
  std::vector<std::pair<std::size_t, Offer>> chosen;
  while (!queue.empty() && queue.top().first >= effort.least_worth) {
    const auto [size, minus] = queue.top();
    queue.pop();
    const auto i = static_cast<std::size_t>(-minus);
    std::erase_if(offers[i].unknowns, [&](std::uint32_t u) { return wanted[u] == 0; });
    if (offers[i].unknowns.size() < size) {
      queue.emplace(offers[i].unknowns.size(), minus);
      continue;
    }
    for (const std::uint32_t u : offers[i].unknowns) wanted[u] = 0;
    chosen.emplace_back(i, offers[i]);
  }
  return chosen;
}

}  // namespace

void extend_cover(Cover& cover, const Sight& sight, const std::vector<Pose2>& poses, const Effort& effort) {
  const std::vector<std::uint8_t> wanted = wanted_of(cover, sight);
  const auto chosen = choose(sight, poses, effort, wanted);
  std::vector<int> completed_by(sight.unknowns().size(), -1);
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    for (const std::uint32_t u : chosen[c].second.unknowns) completed_by[u] = static_cast<int>(c);
  }
  std::vector<std::vector<VoxelIndex>> elements(chosen.size());
  std::erase_if(cover.left, [&](std::uint32_t element) {
    const auto unknowns = sight.unknowns_of(element);
    std::vector<int> by;
    for (const std::uint32_t u : unknowns) by.push_back(completed_by[u]);
    if (std::find(by.begin(), by.end(), -1) != by.end()) return false;
    std::sort(by.begin(), by.end());
    by.erase(std::unique(by.begin(), by.end()), by.end());
    for (const int c : by) elements[static_cast<std::size_t>(c)].push_back(sight.elements()[element].voxel);
    return true;
  });
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    if (elements[c].empty()) continue;
    cover.viewpoints.push_back({poses[chosen[c].first], std::move(elements[c]), chosen[c].second.looks});
  }
}

Cover cover_elements(const Sight& sight, const FreeSpace& free_space, const Pose2& robot, const ViewpointParams& params,
                     const Skipped& skipped) {
  Cover cover;
  for (std::uint32_t i = 0; i < sight.elements().size(); ++i) {
    if (skipped.empty() || skipped[i] == 0) cover.left.push_back(i);
  }
  const std::size_t asked = cover.left.size();
  const double voxel_m2 = sight.voxel_m() * sight.voxel_m();
  for (const Round& round : kRounds) {
    const std::vector<Pose2> poses = Candidates(sight, params).find(cover.left, round, free_space, robot);
    const int looks = round.all_looks ? params.max_looks : params.looks;
    const double least = round.share_of_minimum * params.min_viewpoint_m2 / voxel_m2;
    const std::size_t least_worth = std::max(round.least_worth, static_cast<std::size_t>(std::ceil(least)));
    extend_cover(cover, sight, poses, {looks, params.unknown_reach_m, least_worth});
    cover.postponed = params.min_viewpoint_m2 > 0 && !cover.viewpoints.empty();
    const auto served = static_cast<double>(asked - cover.left.size());
    if (cover.postponed && served * voxel_m2 >= kTourMinima * params.min_viewpoint_m2) break;
  }
  return cover;
}

}  // namespace arpent::planning
