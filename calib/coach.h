// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Tells somebody who holds a board before running cameras what to show next: which part of which image is still empty,
// which tilt is missing; and takes the views that add something. No bus and no clock: tools/calibrate/live_capture.h.
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "calib/views.h"

namespace arpent::calib {

struct CoachParams {
  std::size_t views = 20;
  double coverage_percent = 70;    ///< fields of each image with corners
  std::size_t views_per_tilt = 3;  ///< facing the camera, and each edge away
  double still = 0.003;            ///< of the image's width: what moves more from picture to picture is not held still
  double different = 0.04;         ///< the same, from every view that was taken
  double tilt_rad = 0.25;          ///< counts as tilted
};

class CaptureCoach {
 public:
  CaptureCoach(const Target& target, const std::vector<CameraInput>& cameras, const CoachParams& params = {});

  /// One moment of all cameras, in order of time; what to tell the holder. Takes the view if it is worth it.
  std::string offer(const View& view);

  /// What was taken so far.
  [[nodiscard]] const BoardViews& views() const { return views_; }
  [[nodiscard]] bool complete() const;
  /// What is still missing, a few words each, the most urgent first; empty if complete.
  [[nodiscard]] std::vector<std::string> missing() const;
  [[nodiscard]] double coverage_percent(std::size_t camera) const;

 private:
  enum Tilt { kFacing, kLeftAway, kRightAway, kUpperAway, kLowerAway, kTilts };
  [[nodiscard]] Tilt tilt_of(const View& view) const;
  void take(const View& view);

  CoachParams params_;
  BoardViews views_;
  std::vector<cv::Mat1f> coverage_;  ///< per camera
  std::array<std::size_t, kTilts> tilts_{};
  View last_;
};

/// Mean distance [px] of the corners that two lists share; far if they share none.
[[nodiscard]] double moved_px(const Corners& a, const Corners& b);

}  // namespace arpent::calib
