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
  /// Half window of the sub-pixel search [px]: 2 is 5 x 5. Wider ones take in other fields where the board is slanted
  /// or small (OpenCV's own sample, with 11 x 11, doubles the error of its own chessboard set).
  int half_window_px = 2;
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
