// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Reads stereo calibrations of other tools: Kalibr's camchain.yaml and OpenCV's YAML or XML (M1, D1, M2, D2, R, T as
// its stereo calibration sample writes, in one file or in the pair intrinsics / extrinsics).
#pragma once

#include <filesystem>
#include <vector>

#include "common/camera.h"

namespace arpent::stereo {

/// T_body_left is identity: these files know no body. Throws InputError that names the file and every fault
/// (find_faults).
[[nodiscard]] StereoCalibration read_kalibr_camchain(const std::filesystem::path& file);
/// `files`: one or two. `distortion_model: equidistant` (a key of ours) makes the coefficients k1..k4 of that model.
/// The image size comes from the file (image_width/image_height, size), or from `size_px` when the file has none.
[[nodiscard]] StereoCalibration read_opencv_calibration(const std::vector<std::filesystem::path>& files,
                                                        int width_px = 0, int height_px = 0);
/// Either, by what is in the file; also our own rig file.
[[nodiscard]] StereoCalibration read_calibration(const std::filesystem::path& file, int width_px, int height_px);

}  // namespace arpent::stereo
