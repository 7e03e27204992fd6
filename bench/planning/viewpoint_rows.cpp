// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/planning/viewpoint_rows.h"

#include <map>
#include <numbers>
#include <vector>

#include "bench/mapping/tsdf/workload.h"
#include "planning/viewpoints/clustering.h"
#include "planning/viewpoints/cover.h"
#include "planning/viewpoints/exploration_targets.h"
#include "tests/planning/viewpoints/grid_free_space.h"

namespace arpent::bench {
namespace {

using mapping::TsdfMap;
using planning::Certificate;
using planning::ExplorationTargets;
using planning::GridFreeSpace;
using planning::Sight;
using planning::Targets;
using planning::ViewpointParams;

constexpr int kReferenceEvery = 30;
/// After so many depth images the drive is half done: much is still incomplete, as it is when planning matters.
constexpr int kHalfWay = 75;
constexpr double kClearanceM = 0.45;

planning::LevelCamera rig_camera() {
  const RectifiedStereo stereo{{640, 512, 377, 377, 319.5, 255.5}, 0.26};
  Pose T_body_cam = Pose::Identity();
  T_body_cam.linear() = R_body_from_camera_axes();
  T_body_cam.translation() = Eigen::Vector3d(0.20, 0.13, 0.40);
  return planning::make_level_camera(stereo, T_body_cam, 0.3, 5.0);
}

/// What a robot of 0.45 m may use: squares that are free in the scene and known to be empty at the camera's height.
GridFreeSpace make_free_space(const Room& room, const TsdfMap& map) {
  const Pose T_scene_map = room.T_map_scene().inverse();
  return {{-4, -1}, {22, 19}, 0.1, [&](const Eigen::Vector2d& p) {
            const Eigen::Vector3d p_map(p.x(), p.y(), 0.4);
            const Eigen::Vector3d p_scene = T_scene_map * p_map;
            const auto voxel = map.voxel(map.index_of(p_map));
            return voxel && voxel->distance_m > 0 && map.is_known(map.index_of(p_map)) && p_scene.x() > 0 &&
                   p_scene.x() < 21 && p_scene.y() > 0 && p_scene.y() < 14 &&
                   room.distance({p_scene.x(), p_scene.y(), 0.5}) > kClearanceM;
          }};
}

/// The robot on the ground below a camera of the workload.
Pose2 robot_at(const Room& room, int i) {
  const Pose T_map_cam = room.T_map_scene() * T_scene_cam_at(i);
  const Eigen::Vector3d forward = T_map_cam.linear().col(2);
  return {T_map_cam.translation().x(), T_map_cam.translation().y(), std::atan2(forward.y(), forward.x())};
}

void measure_plan(Report& report, const std::string& suffix, const Room& room, const TsdfMap& map,
                  const std::string& preset, int at, double reference_ms) {
  ViewpointParams params;
  params.preset = preset;
  ExplorationTargets targets(params, rig_camera());
  targets.update(map);
  const GridFreeSpace free_space = make_free_space(room, map);
  Targets planned;
  const double plan_ms = cpu_ms([&] { planned = targets.plan(map, free_space, robot_at(room, at)); });
  std::size_t viewpoints = 0;
  for (const auto& cluster : planned.clusters) viewpoints += cluster.viewpoints.size();
  const std::string name = preset == "thesis" ? "viewpoints_thesis" : "viewpoints";
  report.add(name + ".elements" + suffix, static_cast<double>(planned.elements), "1");
  report.add(name + ".count" + suffix, static_cast<double>(viewpoints), "1", "in clusters:");
  report.add(name + ".clusters" + suffix, static_cast<double>(planned.clusters.size()), "1");
  report.add(name + ".plan_ms" + suffix, plan_ms, "ms", "elements to clusters, certificates of the rest");
  report.add(name + ".plan_ms" + suffix + "_over_ref", plan_ms / reference_ms, "1");
  std::map<std::string, int> reasons;
  for (const Certificate& certificate : planned.remaining) ++reasons[planning::to_text(certificate.verdict)];
  for (const auto& [reason, count] : reasons) report.add(name + ".remaining_" + reason + suffix, count, "1");
}

/// Gain of one viewpoint, both ways of counting: elements seen, and unknown voxels that looks complete.
void measure_gain(Report& report, const std::string& suffix, const Room& room, const TsdfMap& map,
                  double reference_ms) {
  mapping::IncompleteSurface surface;
  surface.update(map);
  const planning::LevelCamera camera = rig_camera();
  const Sight sight(camera, surface, map);
  const GridFreeSpace free_space = make_free_space(room, map);
  const auto cover = planning::cover_elements(sight, free_space, robot_at(room, kHalfWay), {});
  std::vector<double> seen_ms, looks_ms;
  for (const auto& viewpoint : cover.viewpoints) {
    seen_ms.push_back(cpu_ms([&] { (void)sight.see_elements(viewpoint.pose); }));
    looks_ms.push_back(
        cpu_ms([&] { (void)sight.look_at_unknowns(viewpoint.pose, ViewpointParams{}.unknown_reach_m); }));
  }
  const double ms = std::max(median(seen_ms), median(looks_ms));
  report.add("gain.ms_per_viewpoint" + suffix, ms, "ms", "the slower of both ways of counting");
  report.add("gain.ms_per_viewpoint" + suffix + "_over_ref", ms / reference_ms, "1", "bar <= 0.005");
}

void measure(Report& report, double voxel_m, const std::string& suffix, const std::string& bar) {
  const Room room;
  mapping::TsdfParams params;
  params.voxel_m = voxel_m;
  TsdfMap map(params);
  mapping::IncompleteSurface literal(mapping::UnknownRule::kWeight), surface;
  DepthSequence depths(room);
  std::vector<double> update_ms, reference_ms;
  for (int i = 0; i < kPoses; ++i) {
    map.integrate(depths.next(), room.T_map_scene() * T_scene_cam_at(i));
    update_ms.push_back(cpu_ms([&] { surface.update(map); }));
    literal.update(map);
    if (i % kReferenceEvery == 0) reference_ms.push_back(time_reference_once());
    if (i != kHalfWay) continue;
    const double reference = median(reference_ms);
    measure_gain(report, suffix, room, map, reference);
    for (const char* preset : {"default", "thesis"}) {
      measure_plan(report, suffix + "_half_way", room, map, preset, i, reference);
    }
  }
  const double reference = median(reference_ms);
  report.add("ise.update_ms" + suffix, median(update_ms), "ms", "per depth image");
  report.add("ise.update_ms" + suffix + "_over_ref", median(update_ms) / reference, "1", bar);
  report.add("ise.count" + suffix, static_cast<double>(surface.size()), "1", "after the whole drive");
  report.add("ise.count_by_weight" + suffix, static_cast<double>(literal.size()), "1", "Def. 1 by weight alone");
  measure_plan(report, suffix, room, map, "default", kPoses - 1, reference);
}

}  // namespace

void viewpoint_rows(Report& report) {
  measure(report, 0.2, "_r20", "bar <= 0.017");
  measure(report, 0.1, "_r10", "bar <= 0.07");
}

}  // namespace arpent::bench
