// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What one rectified pair says about the tag cube: tags found in the left image, found again in the right one where
// stereo geometry puts them, outlines fitted in both, the body's pose, and whether it can be trusted.
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "common/camera.h"
#include "common/geometry.h"
#include "perception/tags/cube.h"
#include "perception/tags/cube_pose.h"
#include "perception/tags/detector.h"

namespace arpent::tags {

struct Observation {
  std::vector<TagDetection> tags;  ///< of the left image, also those of no cube; corners refined where they could be
  std::string reason;              ///< why there is no pose to use; empty if there is
  CubePose measured;               ///< from the tags alone
  /// On the ground: what is published of this pair alone.
  Pose T_world_body = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();

  [[nodiscard]] bool accepted() const { return reason.empty(); }
};

class TagObserver {
 public:
  /// `T_body_cam`: the rectified left camera on the body. Throws InputError for a cube that cannot be.
  TagObserver(const TagCubeConfig& cube, const DetectorParams& detector, const GroundParams& ground,
              const RectifiedStereo& stereo, const Pose& T_body_cam);

  /// 8-bit images of the camera's size. Deterministic.
  [[nodiscard]] Observation observe(const cv::Mat1b& left, const cv::Mat1b& right) const;

 private:
  [[nodiscard]] cv::Rect search_area(const TagDetection& tag) const;
  [[nodiscard]] std::vector<TagView> fit_views(Observation& observation, const cv::Mat1b& left,
                                               const cv::Mat1b& right) const;

  TagCube cube_;
  TagDetector detector_;
  GroundParams ground_;
  RectifiedStereo stereo_;
  Pose T_body_cam_;
};

}  // namespace arpent::tags
