// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Pictures of a printed board through a lens with distortion: sixteen samples a pixel of the board's artwork, a little
// blur, noise.
#pragma once

#include <opencv2/core.hpp>

#include "calib/target.h"
#include "common/camera.h"
#include "common/geometry.h"
#include "sim/camera/camera_model.h"

namespace arpent::calib {

/// The same seed, the same picture.
[[nodiscard]] cv::Mat1b draw_board(const Target& target, const sim::CameraModel& camera, const Pose& T_cam_board,
                                   std::uint64_t seed);

}  // namespace arpent::calib
