// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// From the map to what the robot should look at next: incomplete surface elements, viewpoints that complete them,
// clusters with gain, and for the elements that no pose completes the reason why. The elements follow the map block by
// block; the rest is made when it is asked for.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "mapping/surface/incomplete_surface.h"
#include "planning/viewpoints/certificate.h"
#include "planning/viewpoints/free_space.h"
#include "planning/viewpoints/level_camera.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

struct Targets {
  std::size_t elements = 0;  ///< |C|: all incomplete elements
  std::vector<Cluster> clusters;
  /// Elements that wait until these clusters are done, because their own viewpoints are worth little, or because nobody
  /// looked yet whether they have any (min_viewpoint_m2).
  std::size_t postponed = 0;
  /// If none wait: elements for which there is no viewpoint, each with the reason: the remaining surface. In the
  /// elements' order. With preset `thesis` the reason may be that the equations have none though a pose would complete
  /// the element.
  std::vector<Certificate> remaining;

  /// Elements of the viewpoint that completes most.
  [[nodiscard]] std::size_t largest() const;
};

/// The region of two corners as config has them, three numbers each.
[[nodiscard]] inline Eigen::AlignedBox3d box_between(const std::vector<double>& min_m,
                                                     const std::vector<double>& max_m) {
  return {Eigen::Map<const Eigen::Vector3d>(min_m.data()), Eigen::Map<const Eigen::Vector3d>(max_m.data())};
}

class ExplorationTargets {
 public:
  /// Throws InputError for parameters that break their rules. `region_map_m`: only surface in there matters.
  ExplorationTargets(const ViewpointParams& params, const LevelCamera& camera,
                     std::optional<Eigen::AlignedBox3d> region_map_m = std::nullopt);
  ~ExplorationTargets();
  ExplorationTargets(ExplorationTargets&&) noexcept;
  ExplorationTargets& operator=(ExplorationTargets&&) noexcept;

  /// Takes over what changed in the map, always the same one; cheap enough for every depth image (bench
  /// `planning`, ise.update_ms).
  void update(const mapping::TsdfMap& map);

  /// Notes that depth images taken at `poses` are in the map (after update()), and no others since the last call. A
  /// voxel that stays unknown is given up, as below the sensing limit, when looks worth give_up_factor times W_th were
  /// in vain: they should have measured it, or were taken at viewpoints meant for it, or showed it from near, nothing
  /// in the way, and said nothing of it. (Before the sky there is no depth: the rims of what stands before it would be
  /// visited for ever.)
  void note_looks(const mapping::TsdfMap& map, std::span<const Pose2> poses);

  /// Notes that all looks which `viewpoint` is meant for were taken there. Elements that are still incomplete after a
  /// second time are given up: below the sensing limit, whatever was promised. Looks that only showed that something
  /// stands before the element count half.
  void note_visit(const mapping::TsdfMap& map, const Viewpoint& viewpoint);

  /// Why each element is incomplete now, in their order, and the poses that were tried for it: what a mission leaves
  /// behind.
  struct Certification {
    std::vector<Certificate> certificates;
    std::vector<Pose2> poses;
  };
  [[nodiscard]] Certification certify(const mapping::TsdfMap& map, const FreeSpace& free_space,
                                      const Pose2& robot) const;

  /// Clusters and remaining elements for a robot at `robot`. A cluster that has at least half of its elements in common
  /// with one of the last plan() keeps its id, others get new ones; the same history gives the same ids. `map` is the
  /// one of the last update().
  [[nodiscard]] Targets plan(const mapping::TsdfMap& map, const FreeSpace& free_space, const Pose2& robot);

  [[nodiscard]] const mapping::IncompleteSurface& surface() const;
  /// Whether nothing that the viewpoint is there for is incomplete any more.
  [[nodiscard]] bool is_complete(const Viewpoint& viewpoint) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::planning
