// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/explorer.h"

#include <algorithm>
#include <deque>
#include <unordered_set>

#include "common/config/config.h"
#include "mapping/tsdf/storage.h"
#include "planning/local/sweep.h"
#include "planning/mission/tour_planner.h"
#include "planning/viewpoints/exploration_targets.h"

namespace arpent::planning {
namespace {

constexpr double kTrailM = 3.0;

/// What the viewpoints ask about the ground, answered from the newest map. Places to which no leg was found are not
/// free, as long as nothing changed there.
class GroundFreeSpace : public FreeSpace {
 public:
  GroundFreeSpace(const Ground& ground, const GroundGrid& grid, const UnreachableGoals& unreachable, const Pose2& robot)
      : ground_(ground), grid_(grid), unreachable_(unreachable), robot_(robot) {}

  [[nodiscard]] bool is_free(const Pose2& pose) const override {
    return ground_.is_free(pose) && !unreachable_.find(pose, robot_, grid_);
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

Eigen::AlignedBox3d region_of(const ExplorerParams& params) {
  return {Eigen::Map<const Eigen::Vector3d>(params.region_min_m.data()),
          Eigen::Map<const Eigen::Vector3d>(params.region_max_m.data())};
}

using VoxelSet = std::unordered_set<VoxelIndex, mapping::BlockHash>;

}  // namespace

struct Explorer::State {
  ExplorerParams params;
  mapping::TsdfMap map;
  ExplorationTargets targets;
  GroundGrid grid;
  Footprint footprint;
  LowLevelPlanner low_level;
  Trail trail{kTrailM};
  ExplorerStatus status;
  std::vector<Certificate> remaining;
  VoxelSet ever;

  /// A tour that is thought out but not yet in force.
  struct Pending {
    Time from;
    PlannedTour tour;
  };
  std::optional<Pending> pending;
  std::vector<Viewpoint> viewpoints;  ///< of the tour in force, by target id
  std::deque<DrivePiece> pieces;      ///< of the leg, that are still to be ordered
  /// Standing at a viewpoint until enough images were taken.
  struct Dwell {
    Viewpoint viewpoint;
    int images = 0;
  };
  std::optional<Dwell> dwell;
  Time moved_at{};
  Pose2 moved_from;

  State(const ExplorerParams& p, const LevelCamera& camera)
      : params(p),
        map(p.tsdf),
        targets(p.viewpoints, camera, region_of(p)),
        grid(p.grid),
        footprint(p.footprint),
        low_level(p.low_level) {}

  void integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) {
    if (!map.integrate(depth, T_map_cam)) return;
    targets.update(map);
    targets.note_look(map, body);
    grid.update(map);
    trail.add(body);
    if (dwell) ++dwell->images;
    const std::vector<VoxelIndex> elements = voxels();
    low_level.set_incomplete(elements);
    ever.insert(elements.begin(), elements.end());
    status.elements = elements.size();
    status.elements_ever = ever.size();
  }

  [[nodiscard]] std::vector<VoxelIndex> voxels() const {
    std::vector<VoxelIndex> voxels;
    for (const auto& element : targets.surface().elements(map)) voxels.push_back(element.voxel);
    return voxels;
  }

  [[nodiscard]] bool is_complete(const Viewpoint& viewpoint) const {
    return std::none_of(viewpoint.elements.begin(), viewpoint.elements.end(),
                        [&](const VoxelIndex& v) { return targets.surface().contains(v); });
  }

  ExplorerOrder step(Time now, const Pose2& pose, bool arrived, bool blocked) {
    note_motion(now, pose);
    if (status.done) return {};
    if (pending && now >= pending->from) adopt();
    if (dwell && !is_complete(dwell->viewpoint) && dwell->images < dwell->viewpoint.looks) {
      status.activity = "looking";
      return {};
    }
    dwell.reset();
    if (blocked) {
      status.activity = "waiting: something is in the way";
      return {};
    }
    const Ground ground(grid, footprint, params.costs);
    const LowLevelOutput output = low_level.step({ground, grid, pose});
    if (output.replan != ReplanReason::kNone && !pending) plan(now, ground, pose, output.replan);
    if (status.done) return {ExplorerOrder::Kind::kStop, {}};
    if (output.visited) begin_dwell(*output.visited);
    return order_for(now, output, arrived);
  }

  void note_motion(Time now, const Pose2& pose) {
    const bool moved = (pose.position_m() - moved_from.position_m()).norm() > 0.02 ||
                       std::abs(wrap_angle(pose.yaw_rad - moved_from.yaw_rad)) > 0.05;
    if (!moved && moved_at != Time{}) return;
    moved_at = now;
    moved_from = pose;
  }

  void adopt() {
    viewpoints = std::move(pending->tour.viewpoints);
    low_level.set_tour(std::move(pending->tour.tour));
    low_level.set_incomplete(voxels());
    pending.reset();
  }

  void plan(Time now, const Ground& ground, const Pose2& pose, ReplanReason reason) {
    const GroundFreeSpace free_space(ground, grid, low_level.unreachable(), pose);
    Targets found = targets.plan(map, free_space, pose);
    remaining = std::move(found.remaining);
    status.clusters = static_cast<int>(found.clusters.size());
    status.activity = std::string("planning: ") + to_text(reason);
    ++status.tours;
    if (found.clusters.empty()) {
      status.done = true;
      status.left_s = 0;
      status.activity = "nothing is left that could be completed";
      return;
    }
    PlannedTour tour = plan_tour(ground, found.clusters, pose, params.tour, params.nominal_speed_mps);
    status.left_s = tour.completion_s;
    pending = Pending{now + from_seconds(params.plan_latency_s), std::move(tour)};
  }

  void begin_dwell(std::int64_t target) {
    pieces.clear();
    const Viewpoint& viewpoint = viewpoints[static_cast<std::size_t>(target)];
    if (!is_complete(viewpoint)) dwell = Dwell{viewpoint, 0};
  }

  ExplorerOrder order_for(Time now, const LowLevelOutput& output, bool arrived) {
    if (output.order == DriveOrder::kFollow) {
      const std::vector<DrivePiece> leg = pieces_of(*output.leg);
      pieces.assign(leg.begin(), leg.end());
      moved_at = now;
      return next_piece();
    }
    if (output.order == DriveOrder::kStop) {
      pieces.clear();
      return {ExplorerOrder::Kind::kStop, {}};
    }
    if (arrived && !pieces.empty()) return next_piece();
    if (low_level.target() && now - moved_at > from_seconds(params.stuck_s)) return give_up_target();
    if (low_level.target()) status.activity = "driving to a viewpoint";
    return {};
  }

  ExplorerOrder next_piece() {
    if (pieces.empty()) return {};
    ExplorerOrder order{ExplorerOrder::Kind::kDrive, std::move(pieces.front())};
    pieces.pop_front();
    return order;
  }

  /// The robot stands though it has a leg to drive: it goes on with a tour made anew.
  ExplorerOrder give_up_target() {
    low_level.set_tour({});
    pieces.clear();
    status.activity = "giving up a leg that could not be driven";
    return {ExplorerOrder::Kind::kStop, {}};
  }
};

Explorer::Explorer(const ExplorerParams& params, const LevelCamera& camera) {
  config::check(params, "explorer");
  state_ = std::make_unique<State>(params, camera);
}
Explorer::~Explorer() = default;

void Explorer::begin(const Pose2& start) {
  state_->grid.declare_free(start.position_m(), state_->params.start_clearance_m);
}

void Explorer::integrate(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) {
  state_->integrate(depth, T_map_cam, body);
}

ExplorerOrder Explorer::step(Time now, const Pose2& pose, bool arrived, bool blocked) {
  return state_->step(now, pose, arrived, blocked);
}

void Explorer::restart() {
  state_->low_level.set_tour({});
  state_->pieces.clear();
  state_->dwell.reset();
}

const ExplorerStatus& Explorer::status() const {
  return state_->status;
}
const mapping::TsdfMap& Explorer::map() const {
  return state_->map;
}
const std::vector<Certificate>& Explorer::remaining() const {
  return state_->remaining;
}

}  // namespace arpent::planning
