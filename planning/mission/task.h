// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a mission does while it runs, apart from its life (lifecycle.h): a test loop, or the exploration of a place.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/pose2.h"
#include "common/time.h"
#include "perception/stereo/depth_map.h"
#include "planning/mission/explorer.h"
#include "planning/mission/loop.h"

namespace arpent::planning {

/// To the path tracker.
struct PathRequest {
  std::vector<Eigen::Vector2d> points_m;  ///< empty: stop
  std::optional<double> goal_heading_rad;
  bool backwards = false;
};

struct TaskProgress {
  double share = 0;    ///< 0 to 1, as far as it can be known
  double left_s = -1;  ///< negative: unknown
  std::string activity;
  bool done = false;
  std::string failure;  ///< why it cannot go on; empty if it can
};

class Task {
 public:
  Task() = default;
  Task(const Task&) = delete;
  Task& operator=(const Task&) = delete;
  virtual ~Task() = default;

  /// The robot knows where it is, and may drive.
  virtual void begin(const Pose2& start) = 0;
  /// A depth image with the poses of camera and body at its time, map frame; comes before begin() as well.
  virtual void see(const stereo::DepthMap& /*depth*/, const Pose& /*T_map_cam*/, const Pose2& /*body*/) {}
  /// Called after each depth image and ten times a second.
  [[nodiscard]] virtual std::optional<PathRequest> step(Time now, const Pose2& pose, const DriveState& drive) = 0;
  /// After a pause: the robot stands, its last order is void.
  virtual void resume(const Pose2& pose, const DriveState& drive) = 0;
  [[nodiscard]] virtual TaskProgress progress(const DriveState& drive) const = 0;
};

/// Throws InputError for a loop that cannot be driven.
[[nodiscard]] std::unique_ptr<Task> make_loop_task(const LoopParams& params);

class ExploreTask : public Task {
 public:
  ExploreTask(const ExplorerParams& params, const LevelCamera& camera) : explorer_(params, camera) {}

  void begin(const Pose2& start) override;
  void see(const stereo::DepthMap& depth, const Pose& T_map_cam, const Pose2& body) override;
  [[nodiscard]] std::optional<PathRequest> step(Time now, const Pose2& pose, const DriveState& drive) override;
  void resume(const Pose2& pose, const DriveState& drive) override;
  [[nodiscard]] TaskProgress progress(const DriveState& drive) const override;
  [[nodiscard]] const Explorer& explorer() const { return explorer_; }
  [[nodiscard]] Explorer& explorer() { return explorer_; }

 private:
  Explorer explorer_;
  bool seen_ = false;  ///< a depth image came since the last step
  bool begun_ = false;
};

}  // namespace arpent::planning
