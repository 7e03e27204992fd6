// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The least squares problem of calibration: corners of one board seen by cameras that are fixed to each other; unknown
// are the lenses, the cameras' places and the board's pose in every view. Solved with Ceres.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "calib/lens.h"
#include "common/geometry.h"

namespace arpent::calib {

struct Observation {
  int view = 0;
  int camera = 0;
  int corner = 0;
  Eigen::Vector2d board_m;  ///< the corner in the board's plane
  Eigen::Vector2d px;
};

struct RigEstimate {
  std::vector<RawCamera> cameras;
  std::vector<Pose> T_cam_first;    ///< per camera; the first one's is identity
  std::vector<Pose> T_first_board;  ///< per view
};

struct SolveOptions {
  bool fix_cameras = false;     ///< only the board's poses are estimated
  bool fix_distortion = false;  ///< coefficients stay as they are
  double cauchy_px = 0;         ///< scale of the robust loss; 0: least squares
  int max_iterations = 100;
};

/// Improves `rig`; returns the cost at the end [px^2], half the sum of (robust) squares; infinite if it could not be
/// evaluated. Single-threaded, deterministic.
double solve(const std::vector<Observation>& observations, RigEstimate& rig, const SolveOptions& options);

/// Predicted minus measured [px], one per observation; infinite for points that are not before the camera.
[[nodiscard]] std::vector<Eigen::Vector2d> residuals(const std::vector<Observation>& observations,
                                                     const RigEstimate& rig);

/// Covariance of all cameras' parameters for a noise of 1 px per coordinate, the board's poses marginalised: per camera
/// the 8 of the lens, then per camera but the first 6 of T_cam_first (translation [m], rotation vector [rad]). Empty if
/// the views do not determine them.
[[nodiscard]] Eigen::MatrixXd unit_covariance(const std::vector<Observation>& observations, const RigEstimate& rig);

}  // namespace arpent::calib
