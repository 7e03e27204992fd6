// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The values that planning hands on: viewpoints and clusters of them, and the parameters that shape them.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "common/config/fields.h"
#include "common/pose2.h"
#include "mapping/tsdf/tsdf_map.h"

namespace arpent::planning {

using mapping::VoxelIndex;

/// A pose from which some of the incomplete surface can be completed.
struct Viewpoint {
  Pose2 pose;                        ///< of the body
  std::vector<VoxelIndex> elements;  ///< the elements that it is there for, in the order of mapping::before()
  int looks = 1;                     ///< depth images that complete them, on the way in or standing
};

/// Viewpoints that are visited together (thesis Sect. 2.4.3).
struct Cluster {
  int id = 0;
  std::vector<Viewpoint> viewpoints;
  std::vector<VoxelIndex> elements;  ///< all that its viewpoints count for the gain, ordered
  double gain = 0;                   ///< share of all elements (eq. 2.1), in [0, 1]
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
};

struct ViewpointParams {
  std::string preset = "default";
  double delta_pose_m = 1.3;
  double merge_voxels = 2.0;
  double merge_angle_deg = 15.0;
  double steep_angle_deg = 30.0;
  int ring = 12;
  double d_v_m = 2.0;
  double d_v_max_m = 3.5;
  double max_diameter_m = 4.0;
  int looks = 4;
  int max_looks = 16;
  double unknown_reach_m = 0.5;
  double lattice_m = 0.25;
  int headings = 24;
  double min_viewpoint_m2 = 0.6;
  double least_piece_m = 2.0;
  double give_up_factor = 4.0;
  double blank_factor = 1.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("preset", self.preset,
                  "thesis: the equations as printed; default: only what looks complete counts, few viewpoints",
                  config::one_of({"default", "thesis"}));
    visitor.field("delta_pose_m", self.delta_pose_m,
                  "distance between camera and element; default: where a closer look is not needed",
                  config::greater_than(0.0));
    visitor.field("merge_voxels", self.merge_voxels, "thesis: viewpoints nearer than this many voxels merge",
                  config::at_least(0.0));
    visitor.field("merge_angle_deg", self.merge_angle_deg, "thesis: if their headings differ by no more than this",
                  config::between(0.0, 90.0));
    visitor.field("steep_angle_deg", self.steep_angle_deg,
                  "directions this near to the vertical say nothing about where to stand", config::between(0.0, 90.0));
    visitor.field("ring", self.ring, "poses tried around an element", config::between(4, 72));
    visitor.field("d_v_m", self.d_v_m, "viewpoints within this path length join a cluster", config::greater_than(0.0));
    visitor.field("d_v_max_m", self.d_v_max_m, "the same for a viewpoint that is alone", config::greater_than(0.0));
    visitor.field("max_diameter_m", self.max_diameter_m, "default: longest path between two viewpoints of a cluster",
                  config::greater_than(0.0));
    visitor.field("looks", self.looks, "default: depth images that a viewpoint is meant for", config::between(1, 1000));
    visitor.field("max_looks", self.max_looks, "default: the same for elements that need more",
                  config::between(1, 1000));
    visitor.field("unknown_reach_m", self.unknown_reach_m,
                  "default: a viewpoint may look this far through unknown space for what it is meant to complete",
                  config::at_least(0.0));
    visitor.field("lattice_m", self.lattice_m, "default: spacing of the poses that are tried",
                  config::between(0.05, 2.0));
    visitor.field("headings", self.headings, "default: headings tried at each of them", config::between(4, 72));
    visitor.field("min_viewpoint_m2", self.min_viewpoint_m2,
                  "default: what completes less surface than this waits until nothing larger is left; 0: nothing waits",
                  config::at_least(0.0));
    visitor.field(
        "least_piece_m", self.least_piece_m,
        "default: incomplete surface is mostly a line, the rim of what was seen; pieces of fewer voxels than fit into "
        "this length are below the sensing limit: seen on the way or not at all",
        config::at_least(0.0));
    visitor.field("give_up_factor", self.give_up_factor,
                  "a voxel that stays unknown after looks worth this many times W_th is below the sensing limit",
                  config::at_least(1.0));
    visitor.field("blank_factor", self.blank_factor,
                  "the same for looks in a row that show the voxel, nothing in the way, and say nothing of it",
                  config::at_least(1.0));
  }
};

}  // namespace arpent::planning
