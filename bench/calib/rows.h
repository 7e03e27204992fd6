// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Rows of bench `calib` that are measured on public pictures.
#pragma once

#include <filesystem>

#include "bench/harness.h"

namespace arpent::bench {

/// OpenCV's stereo chessboard set: the same corners, the same model, OpenCV's calibration and ours.
void add_chessboard_rows(Report& report, const std::filesystem::path& folder);
/// AprilGrid of Kalibr with corners by another detector, and the AprilTag library's own photos.
void add_apriltag_rows(Report& report, const std::filesystem::path& folder);

}  // namespace arpent::bench
