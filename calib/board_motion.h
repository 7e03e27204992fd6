// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The way of calibrated cameras before a board, pose by pose, with what each pose is worth.
#pragma once

#include <vector>

#include "calib/rig_problem.h"
#include "calib/views.h"

namespace arpent::calib {

struct BoardPose {
  Pose T_board_cam = Pose::Identity();  ///< the first camera
  /// (translation [m], rotation [rad]) in the camera's axes, from the corners' own scatter.
  Matrix6d covariance = Matrix6d::Identity();
};

/// One for each view; every view must have corners.
[[nodiscard]] std::vector<BoardPose> camera_poses(const BoardViews& views, const RigEstimate& cameras);

}  // namespace arpent::calib
