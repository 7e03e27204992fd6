// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Calibrations as files: our rig file, and what others read: Kalibr's camchain.yaml and OpenCV's YAML
// (perception/stereo/calibration_file.h reads both back).
#pragma once

#include <string>

#include "calib/rig_problem.h"
#include "common/config/rig.h"

namespace arpent::calib {

/// cam0, cam1, … with T_cn_cnm1 (camera n - 1 to n). Numbers always carry a decimal point, as Kalibr's reader demands.
[[nodiscard]] std::string to_camchain_yaml(const RigEstimate& rig);
/// M1, D1, M2, D2, R, T, image_width, image_height; for an equidistant pair `distortion_model: equidistant` too, a key
/// of ours that OpenCV passes over (its sample for such lenses, cv::fisheye, has the same names).
[[nodiscard]] std::string to_opencv_yaml(const StereoCalibration& stereo);
/// Our rig file with these cameras; name, mounting on the body, range and rate are those of `before`.
[[nodiscard]] RigConfig to_rig_config(const StereoCalibration& stereo, const RigConfig& before);

}  // namespace arpent::calib
