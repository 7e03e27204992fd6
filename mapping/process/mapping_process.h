// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// mapping_process: depth and odometry in, a TSDF map kept, its state out after each fusion. Depth images are joined
// with the odometry of the same pair and fused in the order of their time; where odometry was lost nothing is fused. At
// an orderly end the map and its mesh are saved, if paths are given.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/fields.h"
#include "mapping/tsdf/tsdf_map.h"

namespace arpent {

class body_pose_t;
class depth_t;
class odometry_t;

struct MappingConfig {
  std::filesystem::path rig;
  std::string pose_source = "odometry";
  std::string map_frame = "world";
  mapping::TsdfParams tsdf;
  std::filesystem::path map_file;
  std::filesystem::path mesh_file;
  int latency_us = 60000;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("rig", self.rig, "rig file: intrinsics and mounting of the stereo camera", config::required_path());
    visitor.field("pose_source", self.pose_source,
                  "odometry: the map lies in odom; pair_pose: the fused pose, the map lies in map_frame",
                  config::one_of({"odometry", "pair_pose"}));
    visitor.field("map_frame", self.map_frame, "with pair_pose: depth is passed over until the pose is of this frame",
                  config::one_of({"world", "odom"}));
    visitor.group("tsdf", self.tsdf, "the map");
    visitor.field("map_file", self.map_file, "where the map is saved at the end; empty: nowhere");
    visitor.field("mesh_file", self.mesh_file, "where the mesh (PLY) is saved at the end; empty: nowhere");
    visitor.field("latency_us", self.latency_us, "declared time from depth to map state", config::at_least(0));
  }
};

class MappingProcess {
 public:
  using Config = MappingConfig;
  static constexpr char kName[] = "mapping_process";
  static constexpr char kHelp[] = "Fuses depth images into a TSDF map.";

  /// Throws InputError for a rig or parameters that cannot be used.
  MappingProcess(const Config& config, Bus& bus, Clock& clock);
  ~MappingProcess();

  /// Saves what was asked for. Throws InputError if the disk refuses; what was there before stays.
  void finish();

  [[nodiscard]] const mapping::TsdfMap& map() const;

 private:
  struct State;
  void on_depth(const depth_t& message);
  void on_odometry(const odometry_t& message);
  void on_pair_pose(const body_pose_t& message);
  void fuse_ready();
  std::unique_ptr<State> state_;
};

}  // namespace arpent
