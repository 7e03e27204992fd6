// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a pose of the robot would see of the incomplete surface: rays through the map's empty voxels, cast only towards
// the elements inside the frustum. A snapshot of one state of the map; it answers from several threads at once.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <unordered_set>
#include <vector>

#include "mapping/surface/incomplete_surface.h"
#include "planning/viewpoints/level_camera.h"

namespace arpent::planning {

using mapping::VoxelIndex;

/// What lies on a segment through the map.
struct Trace {
  bool occupied = false;  ///< it meets an occupied voxel; what lies beyond was not looked at
  /// Where it enters its first voxel that is not known, as a share of its length; 1 if there is none.
  double clear_share = 1;
};

/// What voxels are on a ray that the map only infers to be occupied (BlockClasses).
enum class Inferred : std::uint8_t { kBlocks, kIsUnknown };

/// Walks through every voxel of the segment, both ends included. Ends in voxels: map coordinates divided by the voxel's
/// edge.
[[nodiscard]] Trace trace(const mapping::VoxelClasses& classes, const Eigen::Vector3d& from_voxels,
                          const Eigen::Vector3d& to_voxels, Inferred inferred = Inferred::kBlocks);

/// A reach through unknown space that excludes nothing.
inline constexpr double kAnyReachM = std::numeric_limits<double>::infinity();

/// A voxel that must become known before the elements beside it are complete (thesis Def. 3).
struct UnknownVoxel {
  VoxelIndex voxel = VoxelIndex::Zero();
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double missing_weight = 0;  ///< W_th less what it has
  bool given_up = false;      ///< many looks have not made it known
  /// Of the surface beside it: unit normal, and how far above it the voxel is.
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double above_surface_m = 0;
};

using VoxelSet = std::unordered_set<VoxelIndex, mapping::BlockHash>;

/// What one look adds to an unknown voxel, as a share of what it misses.
struct Look {
  std::uint32_t unknown = 0;  ///< index into unknowns()
  float share = 0;
};

class Sight {
 public:
  /// `surface` is up to date with `map`; its classes must outlive this and stay as they are. `given_up`: unknown voxels
  /// from which no more is expected.
  Sight(const LevelCamera& camera, const mapping::IncompleteSurface& surface, const mapping::TsdfMap& map,
        const VoxelSet& given_up = {});

  [[nodiscard]] const LevelCamera& camera() const { return camera_; }
  [[nodiscard]] double voxel_m() const { return voxel_m_; }
  [[nodiscard]] double known_weight() const { return known_weight_; }
  [[nodiscard]] const std::vector<mapping::IncompleteElement>& elements() const { return elements_; }
  [[nodiscard]] const std::vector<UnknownVoxel>& unknowns() const { return unknowns_; }
  /// The unknown voxels beside an element, as indices into unknowns().
  [[nodiscard]] std::span<const std::uint32_t> unknowns_of(std::size_t element) const {
    return std::span(members_).subspan(first_[element], first_[element + 1] - first_[element]);
  }

  /// Whether one of them is given up: looks will not complete the element.
  [[nodiscard]] bool is_given_up(std::size_t element) const;

  /// Elements seen from the pose, by index: a ray reaches them, the first voxel that is not empty lies beyond (thesis
  /// Sect. 2.4.3; elements are empty voxels, so a ray that "touches" one has crossed it). Ascending.
  [[nodiscard]] std::vector<std::uint32_t> see_elements(const Pose2& pose) const;

  /// Unknown voxels that a depth image taken at the pose would say something about, and how much: those that it
  /// measures (see below) and to within one voxel of which a ray comes without meeting an occupied voxel, its last
  /// `unknown_reach_m` at most through unknown space. (At a frontier the way to an unknown voxel leads past others: the
  /// same image tells whether they are empty.) The weight is the map's, 1/z^2 (thesis Sect. 2.4.1). Ascending. Unless
  /// it is empty, only unknowns with a flag in `wanted` are looked at.
  [[nodiscard]] std::vector<Look> look_at_unknowns(const Pose2& pose, double unknown_reach_m,
                                                   std::span<const std::uint8_t> wanted = {}) const;

  /// Whether a ray through the unknown voxel meets the surface beside it, taken to go on as a plane, within the range
  /// of depth. Beyond it there is no depth, and nothing is learned of the voxels before it either: near the floor, a
  /// level camera measures only what is close.
  [[nodiscard]] bool measures(const CameraView& view, const UnknownVoxel& unknown) const;
  /// Whether the view shows the unknown voxel with this centre: it is in view, and a ray comes to it as
  /// look_at_unknowns() says.
  [[nodiscard]] bool shows(const CameraView& view, const Eigen::Vector3d& centre_m, double unknown_reach_m) const;
  /// Whether it would if all that is unknown, or only inferred to be occupied, were empty: that is to be tried.
  [[nodiscard]] bool may_show(const CameraView& view, const Eigen::Vector3d& centre_m) const;
  /// What one look from there adds.
  [[nodiscard]] static double share_of_look(const CameraView& view, const UnknownVoxel& unknown) {
    return 1.0 / ((unknown.centre_m - view.position_m()).squaredNorm() * unknown.missing_weight);
  }

 private:
  [[nodiscard]] bool reaches(const CameraView& view, const Eigen::Vector3d& p_map_m, double stop_short_m,
                             double unknown_reach_m, Inferred inferred) const;

  LevelCamera camera_;
  const mapping::VoxelClasses& classes_;
  double voxel_m_, known_weight_;
  std::vector<mapping::IncompleteElement> elements_;
  std::vector<UnknownVoxel> unknowns_;
  std::vector<std::uint32_t> members_, first_;
};

}  // namespace arpent::planning
