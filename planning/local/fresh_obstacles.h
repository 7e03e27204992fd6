// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What appears: obstacles that depth images show where the map knows free ground. The map is an average of many looks
// and follows within seconds, and only where it is looked at; the robot must not drive there meanwhile. Marked in the
// ground's grid are the cells in which the obstacle shows, those behind it, and those at which a robot pushes against
// what nothing shows: the map's word of them is void until images see past them.
#pragma once

#include <map>
#include <set>
#include <utility>

#include "common/config/fields.h"
#include "common/geometry.h"
#include "perception/stereo/depth_map.h"
#include "planning/local/ground_grid.h"

namespace arpent::planning {

struct FreshObstacleParams {
  double range_m = 2.5;
  double min_height_m = 0.15;
  double max_height_m = 0.6;
  double least_extent_m = 0.06;
  double apart_m = 0.15;
  double behind_m = 0.5;
  int clear_images = 3;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("range_m", self.range_m, "farther depth is too uncertain", config::between(0.0, 20.0));
    visitor.field("min_height_m", self.min_height_m, "lower points are floor", config::between(0.0, 1.0));
    visitor.field("max_height_m", self.max_height_m, "higher points do not hinder the robot",
                  config::between(0.1, 5.0));
    visitor.field("least_extent_m", self.least_extent_m, "a cell counts if so much of its height is seen occupied",
                  config::between(0.0, 1.0));
    visitor.field("apart_m", self.apart_m, "nearer to what the map knows, points are that, and noise",
                  config::between(0.0, 1.0));
    visitor.field("behind_m", self.behind_m, "so far behind what appeared the map's free ground is void",
                  config::between(0.0, 3.0));
    visitor.field("clear_images", self.clear_images, "images in a row that see past a cell and free it",
                  config::at_least(1));
  }
};

class FreshObstacles {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit FreshObstacles(const FreshObstacleParams& params);

  /// One depth image, after `grid` was updated with the map that holds it; always the same grid. What two images in a
  /// row show is marked.
  void look(const stereo::DepthMap& depth, const Pose& T_map_cam, GroundGrid& grid);

  /// A body at `pose` drives forwards and does not get on: something that no image shows may be at the front half of
  /// its rim. Marked until images see past it.
  void touch(const Footprint& body, const Pose2& pose, GroundGrid& grid);

 private:
  using Cell = GroundGrid::Cell;
  [[nodiscard]] std::set<Cell> find(const stereo::DepthMap& depth, const Pose& T_map_cam, const GroundGrid& grid) const;
  /// False if it was marked already.
  bool mark(const Cell& cell, GroundGrid& grid);
  [[nodiscard]] bool is_apart(const Cell& cell, const GroundGrid& grid) const;
  void hold(const Cell& cell, const Eigen::Vector2d& eye_m, GroundGrid& grid);
  void clear(const std::set<Cell>& shown, const stereo::DepthMap& depth, const Pose& T_map_cam, GroundGrid& grid);
  [[nodiscard]] bool sees_past(const Eigen::Vector2d& centre_m, const stereo::DepthMap& depth,
                               const Pose& T_cam_map) const;

  FreshObstacleParams params_;
  std::set<Cell> last_;       ///< that the last image showed
  std::map<Cell, int> held_;  ///< marked, with the images in a row that saw past it
};

}  // namespace arpent::planning
