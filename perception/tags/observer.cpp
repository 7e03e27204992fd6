// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/tags/observer.h"

#include <algorithm>
#include <cmath>

namespace arpent::tags {
namespace {

/// What the first search may be off: in columns by this share of the disparity (a tag's apparent height gives its
/// distance to a few per cent), and everywhere by a white rim and a little more.
constexpr double kDisparityShare = 0.15;
constexpr double kRimShare = 0.3;
constexpr double kMarginPx = 4;

bool is_seen_twice(const std::vector<TagDetection>& tags, int id) {
  return std::count_if(tags.begin(), tags.end(), [&](const TagDetection& t) { return t.id == id; }) > 1;
}

}  // namespace

TagObserver::TagObserver(const TagCubeConfig& cube, const DetectorParams& detector, const GroundParams& ground,
                         const RectifiedStereo& stereo, const Pose& T_body_cam)
    : cube_(cube), detector_(detector), ground_(ground), stereo_(stereo), T_body_cam_(T_body_cam) {}

/// Where a tag of the left image must be in the right one.
cv::Rect TagObserver::search_area(const TagDetection& tag) const {
  Eigen::Vector2d low = tag.corners_px[0];
  Eigen::Vector2d high = low;
  for (const Eigen::Vector2d& corner : tag.corners_px) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  // Tags stand upright: the height does not shrink when they are seen from the side.
  const double height_px = high.y() - low.y();
  const double disparity_px =
      stereo_.baseline_m * height_px / cube_.tag_m() * stereo_.camera.fx_px / stereo_.camera.fy_px;
  const double margin_px = kRimShare * height_px + kMarginPx;
  const double columns_px = margin_px + kDisparityShare * disparity_px;
  const auto left = static_cast<int>(std::floor(low.x() - disparity_px - columns_px));
  const auto right = static_cast<int>(std::ceil(high.x() - disparity_px + columns_px));
  const auto top = static_cast<int>(std::floor(low.y() - margin_px));
  const auto bottom = static_cast<int>(std::ceil(high.y() + margin_px));
  return {left, top, right - left, bottom - top};
}

std::vector<TagView> TagObserver::fit_views(Observation& observation, const cv::Mat1b& left,
                                            const cv::Mat1b& right) const {
  std::vector<TagView> views;
  cv::Rect area;
  for (TagDetection& tag : observation.tags) {
    if (cube_.find_corners(tag.id) == nullptr || is_seen_twice(observation.tags, tag.id)) continue;
    const auto outline = fit_outline(left, tag.corners_px);
    if (!outline) continue;
    tag.corners_px = outline->corners_px;
    views.push_back({tag.id, false, *outline});
    area = area.empty() ? search_area(tag) : area | search_area(tag);
  }
  if (views.empty()) return views;
  const std::vector<TagDetection> found = detector_.detect_in(right, area);
  const std::size_t left_views = views.size();
  for (const TagDetection& tag : found) {
    const bool wanted = std::any_of(views.begin(), views.begin() + static_cast<std::ptrdiff_t>(left_views),
                                    [&](const TagView& v) { return v.id == tag.id; });
    if (!wanted || is_seen_twice(found, tag.id)) continue;
    if (const auto outline = fit_outline(right, tag.corners_px)) views.push_back({tag.id, true, *outline});
  }
  return views;
}

Observation TagObserver::observe(const cv::Mat1b& left, const cv::Mat1b& right) const {
  Observation observation;
  observation.tags = detector_.detect(left);
  if (observation.tags.empty()) {
    observation.reason = "no tag";
    return observation;
  }
  const std::vector<TagView> views = fit_views(observation, left, right);
  observation.measured = solve_cube_pose(cube_, stereo_, T_body_cam_, views);
  observation.reason = observation.measured.reason;
  if (!observation.accepted()) return observation;
  const GroundedPose grounded =
      put_on_ground(observation.measured.T_world_body, observation.measured.covariance, ground_);
  observation.T_world_body = grounded.T_world_body;
  observation.covariance = grounded.covariance;
  if (grounded.chi2 > kGroundGate) observation.reason = "the tags put the body off the ground";
  return observation;
}

}  // namespace arpent::tags
