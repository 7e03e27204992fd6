// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Worlds by formula for the tests and the bench of planning/local: a rectangular room with turned boxes, as exact
// distances, as a ground and as a map. Independent of what is tested.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "mapping/tsdf/storage.h"
#include "planning/local/ground.h"

namespace arpent::planning {

struct FlatBox {
  Eigen::Vector2d centre_m;
  Eigen::Vector2d half_m;
  double yaw_rad = 0;
  double bottom_m = 0;
  double top_m = 2;
};

struct FlatWorld {
  Eigen::Vector2d size_m{8, 7};  ///< the room covers [0, x] x [0, y]
  std::vector<FlatBox> boxes;

  /// To the nearest wall or box at this height, negative inside of one.
  [[nodiscard]] double distance_m(const Eigen::Vector2d& p, double z_m = 0.3) const {
    double d = std::min({p.x(), p.y(), size_m.x() - p.x(), size_m.y() - p.y()});
    for (const FlatBox& box : boxes) {
      const Eigen::Vector2d q = Eigen::Rotation2Dd(-box.yaw_rad) * (p - box.centre_m);
      const Eigen::Vector3d out(std::abs(q.x()) - box.half_m.x(), std::abs(q.y()) - box.half_m.y(),
                                std::max(box.bottom_m - z_m, z_m - box.top_m));
      d = std::min(d, out.cwiseMax(0).norm() + std::min(out.maxCoeff(), 0.0));
    }
    return d;
  }
};

/// Cells as exact distances say: occupied up to half a cell before a surface. Beyond the walls it is unknown.
inline Ground make_ground(const FlatWorld& world, const FootprintParams& footprint = {}, double cell_m = 0.05) {
  constexpr int kBeyond = 6;
  GridFrame frame{cell_m, Eigen::Vector2i::Constant(-kBeyond), 0, 0};
  frame.cols = static_cast<int>(std::ceil(world.size_m.x() / cell_m)) + 2 * kBeyond;
  frame.rows = static_cast<int>(std::ceil(world.size_m.y() / cell_m)) + 2 * kBeyond;
  std::vector<CellState> states(frame.size(), CellState::kUnknown);
  for (int j = 2; j < frame.rows - 2; ++j) {
    for (int i = 2; i < frame.cols - 2; ++i) {
      const double d = world.distance_m(frame.centre_m(i, j));
      if (d > -0.2) states[frame.at(i, j)] = d > 0.5 * cell_m ? CellState::kFree : CellState::kOccupied;
    }
  }
  return Ground(frame, std::move(states), Footprint(footprint));
}

/// The room's map as if everything had been seen well: exact distances to walls, boxes and floor, unknown farther than
/// the truncation distance behind a surface.
inline mapping::TsdfMap make_map(const FlatWorld& world, double voxel_m, double height_m = 1.6) {
  mapping::TsdfParams params;
  params.voxel_m = voxel_m;
  mapping::TsdfMap map(params);
  const double truncation = map.storage().truncation_m(), edge = map.storage().block_edge_m();
  const auto blocks = [&](double metres) { return static_cast<int>(std::ceil(metres / edge)); };
  for (int z = -1; z < blocks(height_m); ++z) {
    for (int y = -1; y <= blocks(world.size_m.y()); ++y) {
      for (int x = -1; x <= blocks(world.size_m.x()); ++x) {
        auto block = std::make_unique<mapping::Block>();
        block->index = {x, y, z};
        for (int i = 0; i < mapping::kBlockVoxels; ++i) {
          const auto at = static_cast<std::size_t>(i);
          const Eigen::Vector3d p =
              map.centre_m(block->index * mapping::kBlockSide + mapping::VoxelIndex(i & 7, i >> 3 & 7, i >> 6));
          const double d = std::min(world.distance_m(p.head<2>(), p.z()), p.z());
          if (d < -truncation) continue;
          block->distance_m[at] = static_cast<float>(std::min(d, truncation));
          block->weight[at] = 1;
        }
        map.storage().adopt(std::move(block));
      }
    }
  }
  return map;
}

inline double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) * 0x1p-32;
}

/// A room of 8 x 7 m with boxes at random.
inline FlatWorld random_world(std::mt19937& random, int boxes) {
  FlatWorld world;
  for (int i = 0; i < boxes; ++i) {
    world.boxes.push_back({{uniform(random, 0.5, 7.5), uniform(random, 0.5, 6.5)},
                           {uniform(random, 0.1, 0.8), uniform(random, 0.1, 0.5)},
                           uniform(random, -3, 3)});
  }
  return world;
}

/// How deep the world reaches into the ellipse at this pose, found by sampling its area; negative if there is room.
inline double intrusion_m(const FlatWorld& world, const FootprintParams& footprint, const Pose2& pose) {
  double least = world.distance_m(pose.position_m());
  for (int i = 0; i < 48; ++i) {
    const double t = 2 * std::numbers::pi * i / 48;
    const Eigen::Vector2d rim(footprint.semi_axis_long_m * std::cos(t), footprint.semi_axis_short_m * std::sin(t));
    for (const double share : {0.5, 1.0}) {
      least = std::min(least, world.distance_m(pose.position_m() + share * (Eigen::Rotation2Dd(pose.yaw_rad) * rim)));
    }
  }
  return -least;
}

}  // namespace arpent::planning
