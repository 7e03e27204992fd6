// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/planning/local_rows.h"

#include "bench/mapping/tsdf/workload.h"
#include "common/error.h"
#include "planning/local/leg_planner.h"
#include "planning/local/stop_guard.h"
#include "tests/planning/local/flat_world.h"

namespace arpent::planning {
namespace {

constexpr int kClusters = 60;
constexpr int kLegs = 60;
constexpr int kPrmLegs = 5;

/// A lot of 21 x 14 m with three pillars and eight boxes.
FlatWorld parking_lot() {
  FlatWorld lot{{21, 14}, {}};
  for (const double x : {6.0, 11.0, 16.0}) lot.boxes.push_back({{x, 7}, {0.25, 0.25}});
  lot.boxes.push_back({{3.2, 11.4}, {0.75, 0.75}, 0});
  lot.boxes.push_back({{8.6, 3.1}, {0.75, 0.75}, 0.3});
  lot.boxes.push_back({{18.2, 10.6}, {0.75, 0.75}, 0});
  lot.boxes.push_back({{12.6, 11.9}, {1.5, 0.25}, 0});
  lot.boxes.push_back({{4.2, 2.6}, {1.5, 0.25}, 0.5});
  lot.boxes.push_back({{13.9, 3.4}, {0.75, 0.25}, 1.2});
  lot.boxes.push_back({{18.6, 4.6}, {0.75, 0.25}, 0.2});
  lot.boxes.push_back({{9.3, 10.6}, {1, 0.35}, 0.7});
  return lot;
}

std::vector<Pose2> free_poses(const Ground& ground, int count) {
  std::mt19937 random(1);
  std::vector<Pose2> poses;
  while (static_cast<int>(poses.size()) < count) {
    const Pose2 pose{uniform(random, 0.3, 20.7), uniform(random, 0.3, 13.7), uniform(random, -3.1, 3.1)};
    if (ground.is_free(pose)) poses.push_back(pose);
  }
  return poses;
}

void price_rows(bench::Report& report, const FlatWorld& lot) {
  const Ground ground = make_ground(lot);
  const std::vector<Pose2> clusters = free_poses(ground, kClusters);
  std::vector<CellState> states(ground.frame().size());
  for (std::size_t at = 0; at < states.size(); ++at) states[at] = ground.state(ground.frame().centre_m(at));
  double sum = 0;
  report.add_time(
      "path.price_all_clusters_ms",
      [&] {
        const Sweep sweep(ground, clusters.front().position_m());
        for (const Pose2& cluster : clusters) sum += sweep.length_m(cluster.position_m()).value_or(0);
      },
      15, "bar <= 0.42; 21 x 14 m at 5 cm, 60 clusters");
  report.add_time(
      "path.ground_ms",
      [&] {
        sum += Ground(ground.frame(), states, ground.footprint()).clearance_m({1, 1});
      },
      15, "distances and costs of all cells, after a change of the map");
  ARPENT_ASSERT(sum > 0);
}

void leg_rows(bench::Report& report, const FlatWorld& lot, const std::string& name, int count) {
  const Ground ground = make_ground(lot);
  const std::vector<Pose2> poses = free_poses(ground, count + 1);
  LegPlannerParams params;
  params.planner = name;
  const LegPlanner planner(params);
  std::vector<double> ms, ratios;
  double turned = 0;
  for (int i = 0; i < count; ++i) {
    const Pose2 &start = poses[static_cast<std::size_t>(i)], &goal = poses[static_cast<std::size_t>(i) + 1];
    LegResult result;
    ms.push_back(bench::cpu_ms([&] { result = planner.plan(ground, start, goal); }));
    if (!result.leg) continue;
    const Sweep sweep(ground, start.position_m());
    ratios.push_back(length_of(result.leg->motions) / *sweep.length_m(goal.position_m()));
    for (const Motion& motion : result.leg->motions) turned += motion.is_turn() ? 1 : 0;
  }
  const std::string prefix = "path.leg_" + name;
  report.add(prefix + "_median_ms", bench::median(ms), "ms");
  report.add(prefix + "_max_ms", *std::max_element(ms.begin(), ms.end()), "ms");
  report.add(prefix + "_found", static_cast<double>(ratios.size()) / count, "1");
  report.add(prefix + "_length_over_sweep", bench::median(ratios), "1");
  report.add(prefix + "_turns_on_the_spot", turned / count, "1", "per leg");
}

void update_rows(bench::Report& report) {
  for (const double voxel_m : {0.1, 0.2}) {
    const bench::Room room;
    bench::DepthSequence sequence(room);
    mapping::TsdfParams params;
    params.voxel_m = voxel_m;
    mapping::TsdfMap map(params);
    GroundGrid grid({});
    std::vector<double> ms;
    const std::string name = voxel_m < 0.15 ? "path.grid_0.10" : "path.grid_0.20";
    for (int i = 0; i < bench::kPoses; ++i) {
      map.integrate(sequence.next(), room.T_map_scene() * bench::T_scene_cam_at(i));
      ms.push_back(bench::cpu_ms([&] { grid.update(map); }));
    }
    report.add(name + "_update_ms", bench::median(ms), "ms", "per depth image");
    const Ground ground(grid, Footprint({}));
    double free = 0;
    for (int i = 0; i < bench::kPoses; ++i) {
      const Pose T = room.T_map_scene() * bench::T_scene_cam_at(i);
      const Eigen::Vector3d ahead = T.linear().col(2);
      free += ground.is_free({T.translation().x(), T.translation().y(), std::atan2(ahead.y(), ahead.x())}) ? 1 : 0;
    }
    report.add(name + "_free_where_driven", free / bench::kPoses, "1", "poses of the drive whose footprint is free");
  }
}

/// A picture with a wall at the edge of what the guard looks at: all points near are judged.
void guard_rows(bench::Report& report) {
  stereo::DepthMap depth;
  depth.camera = {640, 512, 377, 377, 319.5, 255.5};
  depth.depth_m = cv::Mat1f(512, 640, 1.2F);
  Pose T_body_cam = Pose::Identity();
  T_body_cam.linear() = R_body_from_camera_axes();
  T_body_cam.translation() = Eigen::Vector3d(0.2, 0, 0.4);
  StopGuard guard({}, Footprint({}));
  int points = 0;
  report.add_time(
      "path.stop_guard_ms",
      [&] {
        points += guard.look(depth, T_body_cam, {0.5, 0.2}).points;
      },
      15, "one depth image of 640 x 512");
}

}  // namespace

void local_rows(bench::Report& report) {
  const FlatWorld lot = parking_lot();
  price_rows(report, lot);
  leg_rows(report, lot, "lattice", kLegs);
  leg_rows(report, lot, "lazy_prm", kPrmLegs);
  update_rows(report);
  guard_rows(report);
}

}  // namespace arpent::planning
