// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Lens distortion of a RawCamera: from the ideal image plane (x = X/Z, y = Y/Z) to the distorted one and back. Models
// and signs as OpenCV's (radial-tangential) and Kannala-Brandt's (equidistant).
#pragma once

#include "common/camera.h"

namespace arpent::sim {

/// Ideal to distorted plane coordinates.
[[nodiscard]] Eigen::Vector2d distort(const RawCamera& camera, const Eigen::Vector2d& ideal);
/// The inverse by Newton's method, to 1e-10 wherever the lens model can be inverted.
[[nodiscard]] Eigen::Vector2d undistort(const RawCamera& camera, const Eigen::Vector2d& distorted);

}  // namespace arpent::sim
