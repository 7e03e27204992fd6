// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/task.h"

#include "planning/mission/path_progress.h"

namespace arpent::planning {
namespace {

constexpr double kNominalSpeedMps = 0.5;

class LoopTask : public Task {
 public:
  explicit LoopTask(const LoopParams& params) : params_(params) {
    // A loop that cannot be driven is found at the start, not when the robot stands there.
    (void)make_loop({}, params);
  }

  void begin(const Pose2& start) override { ordered_ = make_loop(start, params_); }

  std::optional<PathRequest> step(Time /*now*/, const Pose2& /*pose*/, const DriveState& drive) override {
    if (driving_) {
      done_ = done_ || drive.arrived;
      return std::nullopt;
    }
    driving_ = true;
    return PathRequest{ordered_, std::nullopt, false};
  }

  void resume(const Pose2& pose, const DriveState& drive) override {
    ordered_ = rest_of(ordered_, length_m(ordered_) - drive.remaining_m, pose.position_m());
    driving_ = false;
  }

  [[nodiscard]] TaskProgress progress(const DriveState& drive) const override {
    if (done_) return {1, 0, "the loop is driven", true, {}};
    if (!driving_) return {0, -1, "waiting for the path", false, {}};
    const double whole_m = length_m(ordered_);
    return {1 - drive.remaining_m / whole_m, drive.remaining_m / kNominalSpeedMps, "driving the loop", false, {}};
  }

 private:
  LoopParams params_;
  std::vector<Eigen::Vector2d> ordered_;
  bool driving_ = false;
  bool done_ = false;
};

}  // namespace

std::unique_ptr<Task> make_loop_task(const LoopParams& params) {
  return std::make_unique<LoopTask>(params);
}

void ExploreTask::begin(const Pose2& start) {
  explorer_.begin(start);
  begun_ = true;
}

void ExploreTask::see(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) {
  explorer_.integrate(depth, T_map_cam, body);
  seen_ = true;
}

std::optional<PathRequest> ExploreTask::step(Time now, const Pose2& pose, const DriveState& drive) {
  // Without news there is nothing to decide.
  if (!begun_ || (!std::exchange(seen_, false) && !drive.arrived)) return std::nullopt;
  const ExplorerOrder order = explorer_.step(now, pose, drive);
  switch (order.kind) {
    case ExplorerOrder::Kind::kDrive:
      return PathRequest{order.piece.points_m, order.piece.end_heading_rad, order.piece.backwards};
    case ExplorerOrder::Kind::kStop:
      return PathRequest{};
    case ExplorerOrder::Kind::kGoOn:
      break;
  }
  return std::nullopt;
}

void ExploreTask::resume(const Pose2& /*pose*/, const DriveState& /*drive*/) {
  explorer_.restart();
}

TaskProgress ExploreTask::progress(const DriveState& /*drive*/) const {
  const ExplorerStatus& status = explorer_.status();
  const double open = static_cast<double>(status.elements), ever = static_cast<double>(status.elements_ever);
  TaskProgress progress{ever > 0 ? 1 - open / ever : 0, status.left_s, status.activity, status.done, {}};
  if (status.boxed_in) progress.failure = status.activity;
  progress.activity += ", " + std::to_string(status.elements) + " elements open";
  return progress;
}

}  // namespace arpent::planning
