// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Finds tags of family 36h11 in a grey image with libapriltag. It says which tags are there and where their corners are
// to about half a pixel; edges.h makes that precise.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "common/config/fields.h"

namespace arpent::tags {

struct DetectorParams {
  double decimate = 2.0;
  int max_hamming = 1;
  double min_decision_margin = 30.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("decimate", self.decimate, "outlines are searched at this fraction of the resolution",
                  config::between(1.0, 4.0));
    visitor.field("max_hamming", self.max_hamming, "most bits of a tag that may be wrong", config::between(0, 2));
    visitor.field("min_decision_margin", self.min_decision_margin,
                  "least mean contrast of a tag's bits against their threshold [grey levels]", config::at_least(0.0));
  }
};

using ImageCorners = std::array<Eigen::Vector2d, 4>;

/// Corners [px] bottom left, bottom right, top right, top left of the tag; pixel centres are whole numbers.
struct TagDetection {
  int id = 0;
  int hamming = 0;
  double decision_margin = 0;
  ImageCorners corners_px;
};

class TagDetector {
 public:
  explicit TagDetector(const DetectorParams& params);
  ~TagDetector();
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;

  /// All tags that pass the limits of hamming and margin, by id, then from left to right.
  [[nodiscard]] std::vector<TagDetection> detect(const cv::Mat1b& image) const;
  /// The same within a part of the image, at full resolution; corners are in pixels of the whole image. Empty if the
  /// part has too few pixels for a tag.
  [[nodiscard]] std::vector<TagDetection> detect_in(const cv::Mat1b& image, const cv::Rect& part) const;

 private:
  struct Detector;
  std::unique_ptr<Detector> detector_;
};

}  // namespace arpent::tags
