// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Stops for what stands in the way now: looks at the newest depth image alone, without map, plan or memory but for the
// release. Independent of the planner on purpose. It sees only what the forward camera sees: not what is behind, beside
// or nearer than the camera's shortest range.
#pragma once

#include <span>
#include <vector>

#include "common/twist2.h"
#include "perception/stereo/depth_map.h"
#include "planning/local/footprint.h"

namespace arpent::planning {

struct StopGuardParams {
  double deceleration_mps2 = 0.5;
  double turn_deceleration_radps2 = 3.0;
  double delay_s = 0.35;
  double margin_m = 0.1;
  double side_margin_m = 0.03;
  double min_height_m = 0.1;
  double max_height_m = 0.6;
  int stride_px = 2;
  int min_points = 30;
  int clear_images = 3;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("deceleration_mps2", self.deceleration_mps2, "with which the base surely brakes",
                  config::between(0.05, 10.0));
    visitor.field("turn_deceleration_radps2", self.turn_deceleration_radps2, "the same for turns",
                  config::between(0.05, 50.0));
    visitor.field("delay_s", self.delay_s, "from the picture until the base brakes, its period included",
                  config::between(0.0, 3.0));
    visitor.field("margin_m", self.margin_m, "left free ahead after the stop", config::between(0.0, 2.0));
    visitor.field("side_margin_m", self.side_margin_m, "by which the footprint is grown", config::between(0.0, 0.5));
    visitor.field("min_height_m", self.min_height_m, "lower points are floor", config::between(0.0, 1.0));
    visitor.field("max_height_m", self.max_height_m, "higher points pass above the robot", config::between(0.1, 5.0));
    visitor.field("stride_px", self.stride_px, "one pixel in so many, along both axes", config::between(1, 16));
    visitor.field("min_points", self.min_points, "fewer points in the way are noise", config::at_least(1));
    visitor.field("clear_images", self.clear_images, "images in a row without an obstacle that end a stop",
                  config::at_least(1));
  }
};

struct StopDecision {
  bool stop = false;
  double free_m = 0;       ///< way until the footprint meets the obstacle; the distance looked at if there is none
  double looked_at_m = 0;  ///< stopping distance: v^2 / 2a + delay v + margin
  int points = 0;          ///< in the way within it
};

class StopGuard {
 public:
  /// Throws InputError for parameters that break their rules.
  StopGuard(const StopGuardParams& params, const Footprint& footprint);

  /// One depth image. `T_body_cam` is the mount (body origin on the floor). Backwards motion is not judged.
  [[nodiscard]] StopDecision look(const stereo::DepthMap& depth, const Pose& T_body_cam, const Twist2& twist);
  /// The same for points in body coordinates.
  [[nodiscard]] StopDecision look(std::span<const Eigen::Vector3d> points_body_m, const Twist2& twist);

 private:
  StopGuardParams params_;
  Footprint footprint_;
  bool stopped_ = false;
  int clear_ = 0;
};

}  // namespace arpent::planning
