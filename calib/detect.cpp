// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/detect.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/grid_search.h"
#include "common/error.h"

namespace arpent::calib {
namespace {

/// A half window that takes in no other field than the four that meet: `field_px` is the smallest one's side.
int window_for(double field_px, int most_px) {
  constexpr int kLeastPx = 2;
  return std::clamp(static_cast<int>(0.4 * field_px), kLeastPx, std::max(most_px, kLeastPx));
}

/// Sub-pixel corners: where the grey gradients around a saddle point all meet. A wide window first, which starts that
/// are off by a few pixels need, then the one asked for. What is at the image's edge becomes NaN; OpenCV leaves a
/// corner that runs out of its window where it was.
void refine(const cv::Mat1b& image, double field_px, int most_px, std::vector<cv::Point2f>& points) {
  constexpr int kWidestPx = 12;
  if (points.empty()) return;
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3);
  const int wide_px = window_for(field_px, kWidestPx), fine_px = window_for(field_px, most_px);
  for (const int window_px : {wide_px, fine_px}) {
    cv::cornerSubPix(image, points, {window_px, window_px}, {-1, -1}, until);
  }
  const auto margin = static_cast<float>(fine_px + 1);
  const cv::Rect2f inside(margin, margin, static_cast<float>(image.cols) - 2 * margin - 1,
                          static_cast<float>(image.rows) - 2 * margin - 1);
  for (cv::Point2f& point : points) {
    if (!inside.contains(point)) point = {NAN, NAN};
  }
}

/// The smallest field at a tag's corner: the square in the gap, or the tag's border.
double smallest_field_px(const ImageQuad& quad, const Target& target) {
  double side_px = 1e9;
  for (std::size_t k = 0; k < 4; ++k) side_px = std::min(side_px, (quad[k] - quad[(k + 1) % 4]).norm());
  const double border = target.border_cells / (6.0 + 2 * target.border_cells);
  return side_px * std::min(target.spacing_ratio, border);
}

Corners detect_grid(const TagSearch& search, const Target& target, const cv::Mat1b& image, int most_window_px) {
  Corners corners;
  for (const GridTag& tag : search.find(image)) {
    std::vector<cv::Point2f> points;
    for (const auto& px : tag.quad) points.emplace_back(static_cast<float>(px.x()), static_cast<float>(px.y()));
    const std::vector<cv::Point2f> start = points;
    refine(image, smallest_field_px(tag.quad, target), most_window_px, points);
    for (int k = 0; k < 4; ++k) {
      const cv::Point2f& p = points[static_cast<std::size_t>(k)];
      // One that stayed where it was ran away, and is known to a pixel only.
      const bool refined = std::isfinite(p.x) && p != start[static_cast<std::size_t>(k)];
      if (refined) corners.push_back({4 * tag.number + k, {p.x, p.y}});
    }
  }
  return corners;
}

float grey_at(const cv::Mat1b& image, const cv::Point2f& p) {
  const int u = std::clamp(static_cast<int>(std::lround(p.x)), 0, image.cols - 1);
  const int v = std::clamp(static_cast<int>(std::lround(p.y)), 0, image.rows - 1);
  return image(v, u);
}

/// OpenCV may number the corners from either end. Where the two ends differ (one side odd, one even) the field inside
/// the first corner tells them apart; a board that looks the same from both ends starts at the lower left.
bool starts_at_wrong_end(const cv::Mat1b& image, const std::vector<cv::Point2f>& p, int rows, int columns) {
  const auto at = [&](int row, int column) { return p[static_cast<std::size_t>(row * columns + column)]; };
  const auto field = [&](int row, int column) {
    return grey_at(image,
                   0.25F * (at(row, column) + at(row + 1, column) + at(row, column + 1) + at(row + 1, column + 1)));
  };
  if ((rows + columns) % 2 != 0) return field(0, 0) > field(0, 1);  // the first field inside is black
  const cv::Point2f along = p.back() - p.front();
  return along.x - along.y < 0;
}

/// Corners must run like the board's axes, x right and y up as seen from the front: a mirrored order is turned about.
void order_chessboard(const cv::Mat1b& image, int rows, int columns, std::vector<cv::Point2f>& points) {
  const auto at = [&](int row, int column) { return points[static_cast<std::size_t>(row * columns + column)]; };
  const cv::Point2f x = at(0, columns - 1) - at(0, 0), y = at(rows - 1, 0) - at(0, 0);
  if (x.x * y.y - x.y * y.x > 0) {  // image y points down: a proper board has a negative cross product
    for (int row = 0; row < rows; ++row) {
      std::reverse(points.begin() + row * columns, points.begin() + (row + 1) * columns);
    }
  }
  if (starts_at_wrong_end(image, points, rows, columns)) std::reverse(points.begin(), points.end());
}

Corners detect_chessboard(const Target& target, const cv::Mat1b& image, int half_window_px) {
  std::vector<cv::Point2f> points;
  const int flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;
  if (!cv::findChessboardCorners(image, {target.columns, target.rows}, points, flags)) return {};
  double field_px = 1e9;
  for (std::size_t i = 1; i < points.size(); ++i) field_px = std::min(field_px, cv::norm(points[i] - points[i - 1]));
  refine(image, field_px, half_window_px, points);
  if (std::any_of(points.begin(), points.end(), [](const auto& p) { return !std::isfinite(p.x); })) return {};
  order_chessboard(image, target.rows, target.columns, points);
  Corners corners;
  for (const cv::Point2f& p : points) corners.push_back({static_cast<int>(corners.size()), {p.x, p.y}});
  return corners;
}

}  // namespace

struct BoardDetector::Library {
  std::unique_ptr<TagSearch> tags;
};

BoardDetector::BoardDetector(const Target& target, const DetectorParams& params)
    : target_(target), params_(params), library_(std::make_unique<Library>()) {
  ARPENT_ASSERT(find_faults(target).empty());
  if (target.kind == TargetKind::kAprilGrid) library_->tags = std::make_unique<TagSearch>(target);
}
BoardDetector::~BoardDetector() = default;
BoardDetector::BoardDetector(BoardDetector&&) noexcept = default;
BoardDetector& BoardDetector::operator=(BoardDetector&&) noexcept = default;

Corners BoardDetector::detect(const cv::Mat1b& image) const {
  ARPENT_ASSERT(!image.empty());
  if (target_.kind == TargetKind::kChessboard) return detect_chessboard(target_, image, params_.half_window_px);
  return detect_grid(*library_->tags, target_, image, params_.half_window_px);
}

}  // namespace arpent::calib
