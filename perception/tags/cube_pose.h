// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The body's pose in the world from the outlines of the cube's tags in a rectified pair: one least-squares problem over
// all sides of all tags in both images. It starts from both poses that a square seen by one camera allows; the second
// camera and further faces decide between them, and if they do not, there is no pose.
//
// What one pair knows badly: a face seen frontally hardly changes when the camera turns about the face's own axes and
// moves sideways along the circle that this describes, so that heading and sideways position (and pitch and height)
// share one large error. Two faces on an edge, seen at 45 degrees each, know the heading about five times better.
// Averaging of views at rest halves only what the pixels' noise makes; see alignment.h.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/camera.h"
#include "common/geometry.h"
#include "perception/tags/cube.h"
#include "perception/tags/edges.h"

namespace arpent::tags {

/// One tag of the cube in one of the two images.
struct TagView {
  int id = 0;
  bool in_right = false;
  TagOutline outline;
};

struct CubePose {
  Pose T_world_body = Pose::Identity();
  /// Of the tangent of retract() at the pose: translation [m], rotation [rad] in body axes. Inflated where the sides
  /// fit worse than they say.
  Matrix6d covariance = Matrix6d::Zero();
  /// About 1 if the sides fit as well as they say; infinite if there is no pose at all.
  double reduced_chi2 = std::numeric_limits<double>::infinity();
  std::vector<int> used;  ///< ids of the tags that the pose is made from
  std::string reason;     ///< why the pose cannot be used; empty if it can

  [[nodiscard]] bool usable() const { return reason.empty(); }
};

/// `views`: tags that the cube carries, each id at most once per image. A tag that contradicts the others is left out;
/// a pose needs at least one tag seen in both images, since one camera alone cannot tell a tag of another size.
[[nodiscard]] CubePose solve_cube_pose(const TagCube& cube, const RectifiedStereo& stereo, const Pose& T_body_cam,
                                       const std::vector<TagView>& views);

/// How well the ground is known to be where the body's origin and its z axis say.
struct GroundParams {
  double height_sigma_m = 0.02;
  double tilt_sigma_rad = 0.01;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("height_sigma_m", self.height_sigma_m, "deviation of the body's origin from world z = 0",
                  config::greater_than(0.0));
    visitor.field("tilt_sigma_rad", self.tilt_sigma_rad, "deviation of the body's roll and pitch from 0",
                  config::greater_than(0.0));
  }
};

struct GroundedPose {
  Pose T_world_body;
  Matrix6d covariance;
  /// Squared distance of what was measured from the ground, by both uncertainties: 3 degrees of freedom.
  double chi2 = 0;
};

/// What the pose becomes with the knowledge that the body stands on the ground, z = 0 with roll and pitch 0: a linear
/// update, so that it can be applied once to many views as well as to each. Works for any frame that stands on the
/// ground, such as odom.
[[nodiscard]] GroundedPose put_on_ground(const Pose& T_world_body, const Matrix6d& covariance,
                                         const GroundParams& params);
/// Beyond this (99.9 % of 3 degrees of freedom) the tags contradict the ground.
inline constexpr double kGroundGate = 16.27;

}  // namespace arpent::tags
