// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Simulated views of a board at the level of corners: a rig whose every number is known, boards moved and tilted before
// it, corners projected through the simulator's own lens code, noise added. For tests and benches of calib.
#pragma once

#include <cstdint>

#include "calib/stereo.h"

namespace arpent::calib {

struct SimulationOptions {
  DistortionModel model = DistortionModel::kRadialTangential;
  int views = 40;
  double noise_px = 0.1;
  double tilt_rad = 0.6;  ///< most, about either axis
  double spread = 0.75;   ///< of the image over which the board's centre moves
  bool left_only = false;
};

/// A pair of 1280 x 1024 pixels with distortion, the right camera 0.26 m to the right and slightly turned.
[[nodiscard]] RigEstimate simulated_rig(DistortionModel model);
/// A 6 x 6 AprilGrid of 0.088 m tags as seen by the rig; the same seed, the same views.
[[nodiscard]] BoardViews simulate_views(const RigEstimate& rig, const SimulationOptions& options, std::uint32_t seed);
/// Poses of the same boards.
[[nodiscard]] std::vector<Pose> simulated_boards(const SimulationOptions& options, std::uint32_t seed);

/// All estimated numbers of a rig in the order of Calibration::covariance.
[[nodiscard]] Eigen::VectorXd parameter_vector(const RigEstimate& rig);

}  // namespace arpent::calib
