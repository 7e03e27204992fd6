// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Finds a board's corners in a grey image, to a few hundredths of a pixel. AprilGrid with either border: libapriltag
// with the family's codes laid into the border that the board has, then the tags that it missed, where their neighbours
// say that they must be. Chessboard: OpenCV.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "calib/target.h"

namespace arpent::calib {

/// A corner of the board (Target's numbering) seen at a pixel; pixel centres are whole numbers.
struct Corner {
  int index = 0;
  Eigen::Vector2d px;
};
/// By index, each at most once.
using Corners = std::vector<Corner>;

struct DetectorParams {
  /// Half window of the sub-pixel search [px], at most; it shrinks, down to 2, with the board's fields. 5 halves the
  /// error of what OpenCV's sample does with 11 on OpenCV's own chessboard set (0.215 against 0.444 px; 2 px give
  /// 0.415).
  int half_window_px = 5;
};

class BoardDetector {
 public:
  explicit BoardDetector(const Target& target, const DetectorParams& params = {});
  ~BoardDetector();
  BoardDetector(BoardDetector&&) noexcept;
  BoardDetector& operator=(BoardDetector&&) noexcept;

  /// Empty if the board is not seen. A chessboard is seen whole or not at all; of an AprilGrid, whole tags. Not for
  /// several threads at once.
  [[nodiscard]] Corners detect(const cv::Mat1b& image) const;

 private:
  struct Library;
  Target target_;
  DetectorParams params_;
  std::unique_ptr<Library> library_;
};

}  // namespace arpent::calib
