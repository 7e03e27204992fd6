// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Why an incomplete element stays incomplete: whether any pose that the robot can reach would complete it and, if none
// would, the reason and how many poses were tried (the thesis's remaining surface C_rem, Def. 2). A mission may end
// when every element left has such a reason.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "planning/viewpoints/free_space.h"
#include "planning/viewpoints/sight.h"
#include "planning/viewpoints/viewpoint.h"

namespace arpent::planning {

enum class Verdict : std::uint8_t {
  kCompletable,  ///< `poses` complete it
  kOutOfRange,   ///< no pose at all has it in view: too high or too low for a level camera within the range of depth
  kUnreachable,  ///< poses would have it in view, but the robot cannot stand there
  kOccluded,     ///< it is in view from reachable poses, but always behind occupied voxels
  /// In sight, but looks do not make it known: they weigh too little, or already failed to. Or it belongs to a piece of
  /// incomplete surface so small that it is not told from noise (`small_piece`).
  kBelowSensingLimit,
};

[[nodiscard]] const char* to_text(Verdict verdict);

struct Certificate {
  VoxelIndex element = VoxelIndex::Zero();
  Verdict verdict = Verdict::kCompletable;
  std::vector<Pose2> poses = {};  ///< if completable: one pose for each of its unknown voxels, without repetition
  /// If not: the reachable poses that were tried for the unknown voxel that is in the way (its place), and from how
  /// many of them it is in sight.
  Eigen::Vector3d unknown_m = Eigen::Vector3d::Zero();
  int in_view = 0;
  int in_sight = 0;
  bool small_piece = false;  ///< a pose would complete it, but its piece is below ViewpointParams::least_piece_m
};

/// Tries every reachable pose of a lattice: positions `lattice_m` apart around all elements, kHeadings headings. Only
/// occupied voxels occlude, and of them those at a surface: what is unknown or only inferred to be occupied may turn
/// out to be empty, so it excuses nothing. Poses that measure (Sight) come before those that only show.
class Certifier {
 public:
  static constexpr int kHeadings = 12;

  /// Asks `free_space` about the whole lattice. Keeps references to `sight` and `params`.
  Certifier(const Sight& sight, const FreeSpace& free_space, const Pose2& robot, const ViewpointParams& params);

  [[nodiscard]] Certificate judge(std::size_t element) const;
  /// The reachable poses.
  [[nodiscard]] const std::vector<Pose2>& poses() const { return poses_; }

 private:
  struct Answer {
    Verdict verdict = Verdict::kUnreachable;
    Pose2 pose = {};
    int in_view = 0, in_sight = 0;
  };
  [[nodiscard]] Answer judge_unknown(const UnknownVoxel& unknown) const;
  [[nodiscard]] Answer search(const UnknownVoxel& unknown) const;

  const Sight& sight_;
  const ViewpointParams& params_;
  std::vector<Pose2> poses_;
  std::vector<Eigen::Vector2i> offsets_;  ///< of lattice cells within reach of the camera, nearest first
  std::map<std::pair<int, int>, std::pair<std::size_t, std::size_t>> poses_of_;  ///< cell -> range in poses_
};

}  // namespace arpent::planning
