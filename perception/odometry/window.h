// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Local bundle adjustment: the poses of the last few keyframes and the points seen from them, refined together in
// (u_left, v, u_right). Points are eliminated by the Schur complement, so the cost is linear in their number. What
// separates odometry that drifts one percent from one that drifts two thirds of it.
#pragma once

#include <vector>

#include "perception/odometry/stereo_projection.h"

namespace arpent::odometry {

struct Observation {
  int keyframe = 0;  ///< index into the poses
  Vector3d z_px;     ///< (u_left, v, u_right) as measured, without the disparity offset
  bool has_right = false;
};

struct WindowPoint {
  Vector3d p_odom_m;
  Matrix3d covariance_m2;  ///< out: given the poses
  std::vector<Observation> observations;
};

/// Levenberg-Marquardt with a Cauchy loss. The first `fixed` poses stay as they are. Points behind a camera do not
/// count. The offset is refined with them: in, what is believed of it; out, what the window adds to that. As an
/// observation takes part in several windows, its information is counted by `information_share`.
void refine_window(const RectifiedStereo& stereo, double pixel_sigma_px, int fixed, double information_share,
                   std::vector<Pose>& T_odom_cam, std::vector<WindowPoint>& points, DisparityOffset& offset);

}  // namespace arpent::odometry
