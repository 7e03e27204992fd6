// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "mapping/process/mapping_process.h"

#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/config/rig.h"
#include "common/mesh.h"
#include "common/time_join.h"
#include "mapping/surface/mesh_extraction.h"
#include "mapping/tsdf/map_file.h"
#include "mapping/wire.h"
#include "perception/fusion/wire.h"
#include "perception/odometry/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"

namespace arpent {
namespace {

/// Depth that falls this far behind the newest depth without its pose is passed over.
constexpr Duration kHorizon = std::chrono::seconds(10);

/// Where the body was when a pair was taken; a fault if that is not known.
using PairPose = Result<Pose>;

PairPose to_pair_pose(const odometry::BodyOdometry& odometry) {
  if (odometry.status == odometry::Status::kLost) return Fault{"odometry lost"};
  return odometry.T_odom_body;
}

PairPose to_pair_pose(const fusion::FusedPose& pose, const std::string& map_frame) {
  if (pose.status == fusion::Status::kLost) return Fault{"pose lost"};
  const bool world = pose.frame == fusion::Frame::kWorld;
  if (world != (map_frame == "world")) return Fault{"the pose is not in frame " + map_frame + " yet"};
  return pose.T_frame_body;
}

}  // namespace

struct MappingProcess::State {
  Config config;
  Bus& bus;
  Pose T_body_cam;
  mapping::TsdfMap map;
  mapping::MapStatus status;
  TimeJoin<stereo::StampedDepth, PairPose> join{kHorizon};

  State(const Config& process_config, Bus& process_bus)
      : config(process_config),
        bus(process_bus),
        T_body_cam(stereo::Rectifier(load_rig(config.rig).calibration).T_body_rectified()),
        map(config.tsdf) {
    status.voxel_m = config.tsdf.voxel_m;
  }

  void refuse(const char* channel, const std::string& fault) const {
    bus.health().count(channel, "invalid");
    bus.health().warn(std::string(channel) + ": message dropped: " + fault);
  }

  void reject(const std::string& reason) {
    ++status.rejected;
    bus.health().count(channels::kDepth, "rejected");
    bus.health().warn("depth not fused: " + reason);
  }

  void fuse(const stereo::StampedDepth& depth, const Pose& T_map_body) {
    map.integrate(depth.map, T_map_body * T_body_cam);
    ++status.integrated;
    status.stamp = depth.stamp;
    status.depth_sequence = depth.sequence;
    status.odometry_stamp = depth.stamp;
    status.block_count = static_cast<std::int64_t>(map.block_count());
    status.known_voxel_count = static_cast<std::int64_t>(map.known_voxel_count());
    status.digest = map.digest();
    publish(bus, channels::kMapStatus, to_wire(status));
  }
};

MappingProcess::MappingProcess(const Config& config, Bus& bus, Clock& /*clock*/)
    : state_(std::make_unique<State>(config, bus)) {
  SubscriptionOptions options;
  options.queue_capacity = 32;
  options.latency = Duration(config.latency_us);
  subscribe<depth_t>(bus, channels::kDepth, options, [this](const depth_t& message) { on_depth(message); });
  options.latency = Duration(0);
  options.queue_capacity = 128;
  if (config.pose_source == "odometry") {
    subscribe<odometry_t>(bus, channels::kOdometry, options,
                          [this](const odometry_t& message) { on_odometry(message); });
  } else {
    subscribe<body_pose_t>(bus, channels::kPairPose, options,
                           [this](const body_pose_t& message) { on_pair_pose(message); });
  }
}

MappingProcess::~MappingProcess() = default;

const mapping::TsdfMap& MappingProcess::map() const {
  return state_->map;
}

void MappingProcess::on_depth(const depth_t& message) {
  auto depth = stereo::from_wire(message);
  if (!depth) return state_->refuse(channels::kDepth, depth.fault());
  if (!state_->join.push_left(depth->stamp, std::move(*depth))) {
    return state_->refuse(channels::kDepth, "its time is not after the last one's");
  }
  fuse_ready();
}

void MappingProcess::on_odometry(const odometry_t& message) {
  const auto odometry = odometry::from_wire(message);
  if (!odometry) return state_->refuse(channels::kOdometry, odometry.fault());
  if (!state_->join.push_right(odometry->stamp, to_pair_pose(*odometry))) {
    return state_->refuse(channels::kOdometry, "its time is not after the last one's");
  }
  fuse_ready();
}

void MappingProcess::on_pair_pose(const body_pose_t& message) {
  const auto pose = fusion::from_wire(message);
  if (!pose) return state_->refuse(channels::kPairPose, pose.fault());
  if (!state_->join.push_right(pose->stamp, to_pair_pose(*pose, state_->config.map_frame))) {
    return state_->refuse(channels::kPairPose, "its time is not after the last one's");
  }
  fuse_ready();
}

void MappingProcess::fuse_ready() {
  for (const auto& [stamp, depth, pose] : state_->join.take()) {
    if (!pose) {
      state_->reject("no pose of the same pair");
    } else if (!*pose) {
      state_->reject(pose->fault());
    } else {
      state_->fuse(depth, **pose);
    }
  }
}

void MappingProcess::finish() {
  const Config& config = state_->config;
  if (!config.map_file.empty()) mapping::save_map(config.map_file, state_->map);
  if (!config.mesh_file.empty()) write_ply(config.mesh_file, mapping::extract_mesh(state_->map));
}

}  // namespace arpent
