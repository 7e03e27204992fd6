// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Maps made by hand, voxel by voxel, and the project's camera.
#pragma once

#include <limits>

#include "mapping/tsdf/storage.h"
#include "planning/viewpoints/free_space.h"
#include "planning/viewpoints/level_camera.h"

namespace arpent::planning {

inline RectifiedStereo rig_stereo() {
  return {{640, 512, 377, 377, 319.5, 255.5}, 0.26};
}

inline Pose T_body_rig() {
  Pose T_body_cam = Pose::Identity();
  T_body_cam.linear() = R_body_from_camera_axes();
  T_body_cam.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return T_body_cam;
}

inline LevelCamera rig_camera() {
  return make_level_camera(rig_stereo(), T_body_rig(), 0.3, 5.0);
}

enum class Content { kUnknown, kEmpty, kOccupied };

/// A map of voxels of 0.2 m whose centres lie in the box; the rest was never seen.
template <class ContentAt>
mapping::TsdfMap make_scene(const Eigen::AlignedBox3d& box_m, const ContentAt& content_at) {
  mapping::TsdfParams params;
  params.voxel_m = 0.2;
  mapping::TsdfMap map(params);
  const mapping::BlockIndex least = mapping::block_of(map.index_of(box_m.min()));
  const mapping::BlockIndex most = mapping::block_of(map.index_of(box_m.max()));
  for (int z = least.z(); z <= most.z(); ++z) {
    for (int y = least.y(); y <= most.y(); ++y) {
      for (int x = least.x(); x <= most.x(); ++x) {
        auto block = std::make_unique<mapping::Block>();
        block->index = {x, y, z};
        for (int i = 0; i < mapping::kBlockVoxels; ++i) {
          const Eigen::Vector3d p =
              map.centre_m(mapping::kBlockSide * block->index + mapping::VoxelIndex(i & 7, i >> 3 & 7, i >> 6));
          const Content content = box_m.contains(p) ? content_at(p) : Content::kUnknown;
          if (content == Content::kUnknown) continue;
          block->weight[static_cast<std::size_t>(i)] = 1;
          block->distance_m[static_cast<std::size_t>(i)] = content == Content::kEmpty ? 0.1F : -0.1F;
        }
        map.storage().adopt(std::move(block));
      }
    }
  }
  return map;
}

/// Everywhere, at Euclidean distance.
class OpenGround : public FreeSpace {
 public:
  [[nodiscard]] bool is_free(const Pose2&) const override { return true; }
  [[nodiscard]] std::vector<std::optional<double>> distances_m(
      const Pose2& from, std::span<const Pose2> to,
      double max_m = std::numeric_limits<double>::infinity()) const override {
    std::vector<std::optional<double>> distances;
    for (const Pose2& pose : to) {
      const double d = (pose.position_m() - from.position_m()).norm();
      distances.push_back(d <= max_m ? std::optional(d) : std::nullopt);
    }
    return distances;
  }
};

}  // namespace arpent::planning
