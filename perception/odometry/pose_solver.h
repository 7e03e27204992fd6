// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The camera's pose from points that are known with their uncertainty and seen in one stereo pair: P3P in RANSAC for
// the set of inliers, then a robust refinement in (u_left, v, u_right), in which each point counts by the noise of its
// pixels and of itself together. Far points, whose depth is poorly known, thus fix the rotation and leave the
// translation to near ones.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/odometry/stereo_projection.h"

namespace arpent::odometry {

struct PointMeasurement {
  Vector3d p_odom_m;       ///< the point
  Matrix3d covariance_m2;  ///< its uncertainty, in odom
  Vector3d z_px;           ///< (u_left, v, u_right); u_right is not used unless has_right
  bool has_right = false;
};

struct PoseSolution {
  Pose T_odom_cam = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();  ///< of the tangent of retract() at the solution
  std::vector<bool> inlier;                ///< one per measurement
  int inliers = 0;
  double rms_px = 0;  ///< root mean square of the inliers' residuals in the left image
};

struct PoseSolverOptions {
  double pixel_sigma_px = 0.25;  ///< noise of a tracked pixel
  double ransac_threshold_px = 2.5;
  int ransac_iterations = 150;
};

/// `guess` competes with the P3P hypotheses, so that a good prediction costs few iterations. Deterministic for `seed`.
/// If fewer than 4 measurements agree, `inliers` says how many and the pose is the guess.
[[nodiscard]] PoseSolution solve_pose(const RectifiedStereo& stereo, const std::vector<PointMeasurement>& measurements,
                                      const Pose& guess, std::uint64_t seed, const PoseSolverOptions& options);

}  // namespace arpent::odometry
