// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What calibration starts from: corners of one board in views of one or more cameras, and the checks that tell a user
// what is wrong with them before anything is estimated.
#pragma once

#include <string>
#include <vector>

#include "calib/detect.h"
#include "calib/target.h"

namespace arpent::calib {

struct CameraInput {
  std::string name;
  int width_px = 0;
  int height_px = 0;
};

/// One moment: the corners that each camera saw, none if it did not see the board.
struct View {
  std::string name;
  std::vector<Corners> cameras;
};

struct BoardViews {
  Target target;
  std::vector<CameraInput> cameras;
  std::vector<View> views;
};

/// Fewest views of a camera, and fewest corners that make a view count.
inline constexpr int kMinViews = 4;
inline constexpr int kMinCorners = 12;

/// Drops corners of cameras that see fewer than kMinCorners in a view, and views with nothing left. Throws InputError
/// if what remains cannot be calibrated from: too few views, a camera that shares no view with the others, or a board
/// whose gaps are not what the target says (`tagSpacing` in metres instead of as a ratio).
[[nodiscard]] BoardViews usable_views(const BoardViews& input);

/// The gap ratio that the corners themselves show, and how well it and the target's explain them.
struct SpacingCheck {
  double seen_ratio = 0;
  double seen_rms_px = 0;
  double stated_rms_px = 0;
};
/// Homographies of a few views, over ratios from 0.02 to 1. AprilGrid only.
[[nodiscard]] SpacingCheck check_spacing(const BoardViews& views);

}  // namespace arpent::calib
