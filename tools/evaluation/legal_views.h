// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Where a robot can get to in a true world, and what its camera can see from there: the poses of the body that touch
// nothing, lie in the region and are connected with the start on the ground; from them, what is in the frustum, within
// the range of depth, and in the line of sight (docs/evaluation.md).
#pragma once

#include <memory>

#include "planning/viewpoints/level_camera.h"
#include "sim/world/ground.h"
#include "sim/world/world.h"

namespace arpent::evaluation {

struct LegalViewParams {
  sim::EllipseFootprint footprint;
  planning::LevelCamera camera;
  double step_m = 0.1;   ///< of the lattice on which ways are searched
  double view_m = 0.25;  ///< of the lattice of camera positions
  /// Angle between the line of sight and the surface's normal beyond which a surface is not seen.
  double max_incidence_deg = 80;
};

class LegalViews {
 public:
  static constexpr int kHeadings = 24;

  /// Searches all ways from `start`; 0.1 to 2 s.
  LegalViews(const sim::World& world, const Pose2& start, const LegalViewParams& params);
  ~LegalViews();
  LegalViews(LegalViews&&) noexcept;
  LegalViews& operator=(LegalViews&&) noexcept;

  /// Whether the body can stand there and get there: it touches nothing, and the next pose of the lattice is connected
  /// with the start.
  [[nodiscard]] bool is_reachable(const Pose2& body) const;
  [[nodiscard]] std::size_t pose_count() const;  ///< poses from which views are tried

  /// Whether any of them sees this piece of surface, from either side.
  [[nodiscard]] bool see(const Eigen::Vector3d& p_world_m, const Eigen::Vector3d& normal) const;

  struct Count {
    int in_view = 0;   ///< poses with the point in the frustum
    int in_sight = 0;  ///< of them, those with nothing in between
  };
  /// Lines of sight end `stop_short_m` before the point. With `beam_m` they are in sight only with so much room to all
  /// four sides: what is seen past an edge or along a wall nearer than that is not.
  [[nodiscard]] Count count(const Eigen::Vector3d& p_world_m, double stop_short_m, double beam_m = 0) const;
  /// Whether a camera at `from_m` has the point in the line of sight.
  [[nodiscard]] bool in_line_of_sight(const Eigen::Vector3d& from_m, const Eigen::Vector3d& p_world_m,
                                      double stop_short_m) const;

  [[nodiscard]] const LegalViewParams& params() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent::evaluation
