// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tools/mission/map_growth.h"

#include <arpent/body_pose_t.hpp>
#include <arpent/depth_t.hpp>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "mapping/surface/mesh_extraction.h"
#include "perception/fusion/wire.h"
#include "perception/stereo/rectifier.h"
#include "perception/stereo/wire.h"

namespace arpent::tools {
namespace {

/// Where the body was at each pair, in the map's frame; and the time of the last one.
std::map<Time, Pose> read_poses(const std::filesystem::path& log, const std::string& map_frame) {
  std::map<Time, Pose> poses;
  LogReader reader(log);
  while (const auto event = reader.next()) {
    if (event->channel != channels::kPairPose) continue;
    body_pose_t message;
    std::string fault;
    if (!decode_guarded(event->data, message, fault)) continue;
    const auto pose = fusion::from_wire(message);
    if (!pose || pose->status == fusion::Status::kLost) continue;
    if ((pose->frame == fusion::Frame::kWorld) == (map_frame == "world"))
      poses.emplace(pose->stamp, pose->T_frame_body);
  }
  return poses;
}

}  // namespace

std::int64_t replay_map(const std::filesystem::path& log, const MissionSetting& setting, int moments,
                        const std::function<void(const MapMoment&)>& visit) {
  const std::map<Time, Pose> poses = read_poses(log, setting.replay.mapping.map_frame);
  if (poses.empty()) return 0;
  const Duration step = (poses.rbegin()->first - poses.begin()->first) / moments;
  const Pose T_body_cam = stereo::Rectifier(to_calibration(setting.rig, setting.rig.name)).T_body_rectified();
  mapping::TsdfMap map(setting.replay.mapping.tsdf);
  mapping::IncrementalMesher mesher;
  mapping::IncompleteSurface incomplete(mapping::UnknownRule::kSignChange, setting.world.region.box_m());
  const auto stop = [&](Time stamp) {
    mesher.update(map);
    incomplete.update(map);
    const TriangleMesh mesh = mesher.mesh();
    visit({stamp, mesh, incomplete.size()});
  };
  std::int64_t fused = 0;
  Time next = poses.begin()->first + step;
  LogReader reader(log);
  while (const auto event = reader.next()) {
    if (event->channel != channels::kDepth) continue;
    depth_t message;
    std::string fault;
    if (!decode_guarded(event->data, message, fault)) continue;
    const auto pose = poses.find(from_utime(message.utime));
    const auto depth = stereo::from_wire(message);
    if (pose == poses.end() || !depth || !map.integrate(depth->map, pose->second * T_body_cam)) continue;
    ++fused;
    if (pose->first < next) continue;
    stop(pose->first);
    next += step;
  }
  stop(poses.rbegin()->first);
  return fused;
}

}  // namespace arpent::tools
