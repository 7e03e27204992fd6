// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Calibrations as files that others read: Kalibr's camchain.yaml and OpenCV's YAML
// (perception/stereo/calibration_file.h reads both back).
#pragma once

#include <string>

#include "calib/rig_problem.h"

namespace arpent::calib {

/// cam0, cam1, … with T_cn_cnm1 (camera n - 1 to n). Numbers always carry a decimal point, as Kalibr's reader demands.
[[nodiscard]] std::string to_camchain_yaml(const RigEstimate& rig);
/// M1, D1, M2, D2, R, T, image_width, image_height. Radial-tangential pairs only: OpenCV's file names no lens model.
[[nodiscard]] std::string to_opencv_yaml(const StereoCalibration& stereo);

}  // namespace arpent::calib
