// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bench/planning/exploration_loop.h"

#include <algorithm>
#include <cstdio>
#include <deque>

#include "bench/harness.h"
#include "planning/local/low_level_planner.h"
#include "planning/local/sweep.h"
#include "planning/mission/tour_planner.h"
#include "planning/viewpoints/exploration_targets.h"
#include "sim/camera/tracer.h"

namespace arpent::bench {
namespace {

using namespace planning;

constexpr double kPeriodS = 0.2;
constexpr double kSpeedMps = 0.5;
constexpr double kTurnRadps = 1.0;
constexpr double kStartClearanceM = 0.8;
constexpr double kReplanS = 2.0;
constexpr double kBackOffM = 0.5;
/// About a viewpoint: the map may still find the surface to be nearer.
constexpr double kRoomM = 0.04;
/// The rig's field of view with fewer pixels: at 5 m they are 3 cm apart.
const PinholeCamera kCamera{320, 256, 188.5, 188.5, 159.5, 127.5};
constexpr double kBaselineM = 0.26;

Pose T_body_cam() {
  Pose T = Pose::Identity();
  T.linear() = R_body_from_camera_axes();
  T.translation() = Eigen::Vector3d(0.20, kBaselineM / 2, 0.40);
  return T;
}

/// Exact depth of a world, as far as stereo tells anything.
constexpr float kFarM = 30.0F;

class DepthCamera {
 public:
  explicit DepthCamera(const sim::World& world) : tracer_(sim::make_surface_mesh(world)) {}

  [[nodiscard]] stereo::DepthMap look(const Pose& T_world_cam) const {
    const cv::Size size(kCamera.width_px, kCamera.height_px);
    stereo::DepthMap depth{kCamera, cv::Mat1f(size, 0.0F), cv::Mat1f(size, 0.0F)};
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; u += sim::kLanes) {
        sim::RayPacket packet;
        for (int i = 0; i < sim::kLanes; ++i) {
          const auto lane = static_cast<std::size_t>(i);
          const Eigen::Vector3d ray = T_world_cam.linear() * kCamera.unproject(u + i, v, 1);
          for (std::size_t k = 0; k < 3; ++k) {
            packet.origin[k][lane] = static_cast<float>(T_world_cam.translation()[static_cast<int>(k)]);
            packet.direction[k][lane] = static_cast<float>(ray[static_cast<int>(k)]);
          }
        }
        packet.t.fill(kFarM);
        packet.facet.fill(-1);
        tracer_.intersect(packet);
        for (int i = 0; i < sim::kLanes; ++i) {
          const auto lane = static_cast<std::size_t>(i);
          if (packet.facet[lane] < 0 || packet.t[lane] < 0.3F) continue;
          depth.depth_m(v, u + i) = packet.t[lane];
          depth.sigma_m(v, u + i) = 0.01F;
        }
      }
    }
    return depth;
  }

 private:
  sim::Tracer tracer_;
};

/// The newest ground as viewpoints ask about it.
class GroundFreeSpace : public FreeSpace {
 public:
  GroundFreeSpace(const Ground& ground, const GroundGrid& grid, const UnreachableGoals& unreachable, const Pose2& robot)
      : ground_(ground), grid_(grid), unreachable_(unreachable), robot_(robot) {}

  [[nodiscard]] bool is_free(const Pose2& pose) const override {
    return ground_.margin_m(pose) >= kRoomM && !unreachable_.find(pose, robot_, grid_);
  }
  [[nodiscard]] std::vector<std::optional<double>> distances_m(const Pose2& from, std::span<const Pose2> to,
                                                               double max_m) const override {
    return drive_lengths_m(ground_, from, to, max_m);
  }

 private:
  const Ground& ground_;
  const GroundGrid& grid_;
  const UnreachableGoals& unreachable_;
  Pose2 robot_;
};

mapping::TsdfParams map_params(double voxel_m) {
  mapping::TsdfParams params;
  params.voxel_m = voxel_m;
  return params;
}

class Loop {
 public:
  Loop(const sim::World& world, const LoopParams& params)
      : params_(params),
        camera_(world),
        map_(map_params(params.voxel_m)),
        targets_(params.viewpoints, make_level_camera({kCamera, kBaselineM}, T_body_cam(), 0.3, 5.0),
                 world.region.box_m()),
        pose_(world.starts.front()) {
    grid_.declare_free(pose_.position_m(), kStartClearanceM);
  }

  LoopResult run() {
    look();
    while (result_.time_s < params_.longest_s && !result_.finished) {
      drop_completed();
      const Ground ground(grid_, footprint_);
      LowLevelOutput output = low_level_.step({ground, grid_, pose_});
      if (output.order == DriveOrder::kStop) motions_.clear();
      if (output.visited) stay(*output.visited);
      if (output.replan != ReplanReason::kNone || result_.time_s - planned_at_s_ > kReplanS) {
        plan(output);
      }
      if (output.leg) motions_.assign(output.leg->motions.begin(), output.leg->motions.end());
      if (output.replan == ReplanReason::kNothingReachable) back_off();
      advance(kPeriodS);
      look();
    }
    for (const Certificate& c : last_.remaining) result_.completable_left += c.verdict == Verdict::kCompletable ? 1 : 0;
    result_.elements_left = targets_.surface().size();
    result_.known_voxels = map_.known_voxel_count();
    return std::move(result_);
  }

 private:
  void look() {
    if (trail_.empty() || !(trail_.back() == pose_)) trail_.push_back(pose_);
    const Pose T_map_cam = pose_.to_pose() * T_body_cam();
    map_.integrate(camera_.look(T_map_cam), T_map_cam);
    targets_.update(map_);
    result_.note_look_ms.push_back(cpu_ms([&] { targets_.note_looks(map_, {&pose_, 1}); }));
    grid_.update(map_);
    low_level_.set_incomplete(targets_.surface().voxels());
    result_.time_s += kPeriodS;
  }

  /// Looks until the viewpoint has what it was meant for.
  void stay(std::int64_t target) {
    ++result_.visits;
    motions_.clear();
    std::erase_if(tour_.tour.targets, [&](const TourTarget& t) { return t.id == target; });
    const Viewpoint viewpoint = tour_.viewpoints[static_cast<std::size_t>(target)];
    for (int i = 0; i < viewpoint.looks && !targets_.is_complete(viewpoint); ++i) look();
  }

  void drop_completed() {
    auto& targets = tour_.tour.targets;
    const std::size_t dropped = std::erase_if(targets, [&](const TourTarget& t) {
      return targets_.is_complete(tour_.viewpoints[static_cast<std::size_t>(t.id)]);
    });
    if (dropped == 0) return;
    low_level_.set_tour(tour_.tour);
    low_level_.set_incomplete(targets_.surface().voxels());
  }

  void plan(LowLevelOutput& output) {
    planned_at_s_ = result_.time_s;
    double targets_ms = 0;
    const double total_ms = cpu_ms([&] {
      const Ground ground(grid_, footprint_);
      const GroundFreeSpace free_space(ground, grid_, low_level_.unreachable(), pose_);
      targets_ms = cpu_ms([&] { last_ = targets_.plan(map_, free_space, pose_); });
      result_.finished = last_.clusters.empty();
      if (result_.finished) return;
      tour_ = plan_tour(ground, last_.clusters, pose_, {}, {.speed_mps = kSpeedMps});
      low_level_.set_tour(tour_.tour);
      low_level_.set_incomplete(targets_.surface().voxels());
      const LowLevelOutput next = low_level_.step({ground, grid_, pose_});
      if (next.order == DriveOrder::kStop) motions_.clear();
      if (next.leg) output.leg = next.leg;
      if (next.visited) visited_late_ = next.visited;
    });
    if (visited_late_) stay(*std::exchange(visited_late_, std::nullopt));
    result_.total_ms.push_back(total_ms);
    result_.targets_ms.push_back(targets_ms);
    if (params_.progress) print_progress();
  }

  void print_progress() const {
    std::size_t viewpoints = 0, tiny = 0;
    for (const Cluster& cluster : last_.clusters) {
      for (const Viewpoint& v : cluster.viewpoints) {
        ++viewpoints;
        tiny += v.elements.size() <= 3 ? 1U : 0U;
      }
    }
    std::printf(
        "%7.1f s %6.1f m  (%5.2f %5.2f %5.2f)  elements %5zu  clusters %3zu viewpoints %3zu tiny %3zu remaining %4zu  "
        "%6.1f ms, targets %6.1f\n",
        result_.time_s, result_.path_m, pose_.x_m, pose_.y_m, pose_.yaw_rad, last_.elements, last_.clusters.size(),
        viewpoints, tiny, last_.remaining.size(), result_.total_ms.back(), result_.targets_ms.back());
    std::fflush(stdout);
  }

  /// No leg leads on from here: back on the way it came.
  void back_off() {
    ++result_.back_offs;
    double left_m = kBackOffM;
    motions_.clear();
    while (left_m > 0 && !trail_.empty()) {
      const Pose2 back = trail_.back();
      trail_.pop_back();
      const double step_m = (back.position_m() - pose_.position_m()).norm();
      left_m -= step_m;
      result_.path_m += step_m;
      result_.time_s += step_m / kSpeedMps + std::abs(wrap_angle(back.yaw_rad - pose_.yaw_rad)) / kTurnRadps;
      pose_ = back;
    }
  }

  void advance(double time_s) {
    while (time_s > 1e-9 && !motions_.empty()) {
      const Motion motion = motions_.front();
      const double takes_s = motion.is_turn() ? std::abs(motion.turn_rad) / kTurnRadps : motion.length_m / kSpeedMps;
      const double share = takes_s <= time_s ? 1 : time_s / takes_s;
      result_.path_m += share * motion.length_m;
      pose_ = pose_at(motion, share);
      time_s -= share * takes_s;
      motions_.pop_front();
      if (share >= 1) continue;
      Motion rest = motion;
      rest.start = pose_;
      rest.length_m *= 1 - share;
      rest.turn_rad *= 1 - share;
      motions_.push_front(rest);
    }
  }

  LoopParams params_;
  DepthCamera camera_;
  mapping::TsdfMap map_;
  ExplorationTargets targets_;
  GroundGrid grid_{{}};
  Footprint footprint_{{}};
  LowLevelPlanner low_level_{{}};
  Pose2 pose_;
  Targets last_;
  PlannedTour tour_;
  std::deque<Motion> motions_;
  std::vector<Pose2> trail_;
  std::optional<std::int64_t> visited_late_;
  double planned_at_s_ = -1e9;
  LoopResult result_;
};

}  // namespace

LoopResult explore(const sim::World& world, const LoopParams& params) {
  return Loop(world, params).run();
}

}  // namespace arpent::bench
