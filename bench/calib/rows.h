// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rows of bench `calib` that are measured on public pictures and on whole missions.
#pragma once

#include <filesystem>

#include "bench/harness.h"

namespace arpent::bench {

/// OpenCV's stereo chessboard set: the same corners, the same model, OpenCV's calibration and ours.
void add_chessboard_rows(Report& report, const std::filesystem::path& folder);
/// AprilGrid of Kalibr with corners by another detector, and the AprilTag library's own photos.
void add_apriltag_rows(Report& report, const std::filesystem::path& folder);
/// The square mission with perception on a rig as calibrated from pictures of a board that the true rig took, over the
/// mission on the true rig.
void add_square_rows(Report& report);

}  // namespace arpent::bench
