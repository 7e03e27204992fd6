// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/grid_search.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>

#include <algorithm>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "calib/tag_code.h"

namespace arpent::calib {
namespace {

/// Where libapriltag has the centre of the top-left pixel.
constexpr double kLibraryPixelCentre = 0.5;
constexpr float kMinDecisionMargin = 20;  // grey levels
/// A tag that the neighbours predict may have this many of its cells wrong: of 8 x 8 or 10 x 10, borders included.
/// 36h11 tells its tags apart by 11 bits, and place and id are known here, so that this is far from chance.
constexpr int kMaxWrongCells = 8;
constexpr int kNeighbours = 4;

struct FamilyDeleter {
  void operator()(apriltag_family_t* family) const { tag36h11_destroy(family); }
};
struct LibraryDeleter {
  void operator()(apriltag_detector_t* detector) const { apriltag_detector_destroy(detector); }
};
struct DetectionsDeleter {
  void operator()(zarray_t* detections) const { apriltag_detections_destroy(detections); }
};

cv::Point2d to_cv(const Eigen::Vector2d& p) {
  return {p.x(), p.y()};
}

/// Least squares homography from the board [m] to the image; empty if there is none.
cv::Mat1d fit_homography(const Target& target, const std::vector<const GridTag*>& tags) {
  std::vector<cv::Point2d> board, image;
  for (const GridTag* tag : tags) {
    for (int k = 0; k < 4; ++k) {
      board.push_back(to_cv(target.corner_m(4 * tag->number + k)));
      image.push_back(to_cv(tag->quad[static_cast<std::size_t>(k)]));
    }
  }
  return cv::findHomography(board, image);
}

Eigen::Vector2d apply(const cv::Mat1d& H, const Eigen::Vector2d& p) {
  const double w = H(2, 0) * p.x() + H(2, 1) * p.y() + H(2, 2);
  return {(H(0, 0) * p.x() + H(0, 1) * p.y() + H(0, 2)) / w, (H(1, 0) * p.x() + H(1, 1) * p.y() + H(1, 2)) / w};
}

/// The `count` tags of `found` next to tag `number` on the board, itself left out.
std::vector<const GridTag*> nearest_tags(const Target& target, const std::vector<GridTag>& found, int number,
                                         int count) {
  std::vector<const GridTag*> nearest;
  for (const GridTag& tag : found) {
    if (tag.number != number) nearest.push_back(&tag);
  }
  const auto distance2 = [&](const GridTag* tag) {
    const int dx = tag->number % target.columns - number % target.columns;
    const int dy = tag->number / target.columns - number / target.columns;
    return std::pair(dx * dx + dy * dy, tag->number);
  };
  std::sort(nearest.begin(), nearest.end(), [&](auto* a, auto* b) { return distance2(a) < distance2(b); });
  if (static_cast<int>(nearest.size()) > count) nearest.resize(static_cast<std::size_t>(count));
  return nearest;
}

ImageQuad predict(const Target& target, const cv::Mat1d& H, int number) {
  ImageQuad quad;
  for (int k = 0; k < 4; ++k) quad[static_cast<std::size_t>(k)] = apply(H, target.corner_m(4 * number + k));
  return quad;
}

double side_px(const ImageQuad& quad) {
  double sum = 0;
  for (std::size_t k = 0; k < 4; ++k) sum += (quad[k] - quad[(k + 1) % 4]).norm() / 4;
  return sum;
}

/// A predicted outline drawn to the corners that are really there: a homography through neighbours misses those of a
/// bent image by a few pixels.
ImageQuad snap(const cv::Mat1b& image, const Target& target, const ImageQuad& quad) {
  std::vector<cv::Point2f> points;
  for (const auto& p : quad) points.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  const cv::Rect2f inside(0, 0, static_cast<float>(image.cols), static_cast<float>(image.rows));
  if (!std::all_of(points.begin(), points.end(), [&](const auto& p) { return inside.contains(p); })) return quad;
  const int window_px = std::clamp(static_cast<int>(0.5 * std::min(target.spacing_ratio, 0.2) * side_px(quad)), 2, 12);
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 20, 0.01);
  cv::cornerSubPix(image, points, {window_px, window_px}, {-1, -1}, until);
  ImageQuad snapped;
  for (std::size_t k = 0; k < 4; ++k) snapped[k] = {points[k].x, points[k].y};
  return snapped;
}

/// Tags far from where their neighbours say (the family's other tags in the room, a board's copy).
std::vector<GridTag> keep_consistent(const Target& target, const std::vector<GridTag>& found) {
  std::vector<GridTag> kept;
  for (const GridTag& tag : found) {
    const auto neighbours = nearest_tags(target, found, tag.number, kNeighbours);
    if (neighbours.empty()) continue;  // a single tag cannot be checked
    const cv::Mat1d H = fit_homography(target, neighbours);
    if (H.empty()) continue;
    const ImageQuad quad = predict(target, H, tag.number);
    double worst_px = 0;
    for (std::size_t k = 0; k < 4; ++k) worst_px = std::max(worst_px, (quad[k] - tag.quad[k]).norm());
    if (worst_px < 0.25 * side_px(tag.quad) + 1) kept.push_back(tag);
  }
  return kept;
}

}  // namespace

struct TagSearch::Library {
  std::unique_ptr<apriltag_family_t, FamilyDeleter> family{tag36h11_create()};
  std::unique_ptr<apriltag_detector_t, LibraryDeleter> detector{apriltag_detector_create()};

  explicit Library(int border_cells) {
    // The library decodes wherever the family says that bits are: with a border of two, each a cell further in.
    const int more = border_cells - 1;
    family->width_at_border += 2 * more;
    family->total_width += 2 * more;
    for (std::uint32_t i = 0; i < family->nbits; ++i) {
      family->bit_x[i] += static_cast<std::uint32_t>(more);
      family->bit_y[i] += static_cast<std::uint32_t>(more);
    }
    apriltag_detector_add_family_bits(detector.get(), family.get(), 1);
    detector->nthreads = 1;
    detector->quad_decimate = 1;
    detector->refine_edges = false;
  }
};

TagSearch::TagSearch(const Target& target) : target_(target), library_(std::make_unique<Library>(target.border_cells)) {
  for (int number = 0; number < target.rows * target.columns; ++number) {
    const TagCode code(target.first_id + number, target.border_cells);
    std::vector<bool> cells;
    for (int row = 0; row < code.cells(); ++row) {
      for (int column = 0; column < code.cells(); ++column) cells.push_back(code.is_black(row, column));
    }
    black_cells_.push_back(cells);
  }
}
TagSearch::~TagSearch() = default;

std::vector<GridTag> TagSearch::run_library(const cv::Mat1b& image) const {
  image_u8_t view{image.cols, image.rows, static_cast<int>(image.step), image.data};
  const std::unique_ptr<zarray_t, DetectionsDeleter> found(apriltag_detector_detect(library_->detector.get(), &view));
  std::map<int, std::pair<float, GridTag>> best;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found.get(), i, &detection);
    const int number = detection->id - target_.first_id;
    if (number < 0 || number >= target_.rows * target_.columns || detection->decision_margin < kMinDecisionMargin)
      continue;
    GridTag tag{number, {}};
    for (std::size_t k = 0; k < 4; ++k) {
      tag.quad[k] = {detection->p[k][0] - kLibraryPixelCentre, detection->p[k][1] - kLibraryPixelCentre};
    }
    const auto at = best.find(number);
    if (at == best.end() || at->second.first < detection->decision_margin) {
      best[number] = {detection->decision_margin, tag};
    }
  }
  std::vector<GridTag> tags;
  for (const auto& [number, entry] : best) tags.push_back(entry.second);
  return tags;
}

/// Whether the cells in `quad` are those of the tag: black against white by a threshold between the two means.
bool TagSearch::carries_tag(const cv::Mat1b& image, int number, const ImageQuad& quad) const {
  const int cells = 6 + 2 * target_.border_cells;
  const std::vector<bool>& black = black_cells_[static_cast<std::size_t>(number)];
  std::vector<cv::Point2d> ends{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, corners;
  for (const auto& p : quad) corners.push_back(to_cv(p));
  const cv::Mat1d H = cv::findHomography(ends, corners);
  if (H.empty()) return false;
  std::vector<double> levels;
  double sum[2] = {0, 0}, count[2] = {0, 0};
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const Eigen::Vector2d p = apply(H, {(column + 0.5) / cells, 1 - (row + 0.5) / cells});
      const int u = static_cast<int>(std::floor(p.x())), v = static_cast<int>(std::floor(p.y()));
      if (u < 0 || v < 0 || u + 1 >= image.cols || v + 1 >= image.rows) return false;
      const double a = p.x() - u, b = p.y() - v;
      levels.push_back((1 - b) * ((1 - a) * image(v, u) + a * image(v, u + 1)) +
                       b * ((1 - a) * image(v + 1, u) + a * image(v + 1, u + 1)));
      const std::size_t side = black[levels.size() - 1] ? 0 : 1;
      sum[side] += levels.back();
      count[side] += 1;
    }
  }
  const double dark = sum[0] / count[0], bright = sum[1] / count[1];
  if (bright - dark < kMinDecisionMargin) return false;
  int wrong = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) wrong += (levels[i] < 0.5 * (dark + bright)) != black[i];
  return wrong <= kMaxWrongCells;
}

/// The library's search for outlines loses tags whose corners run into the squares between them. Their neighbours say
/// where they are; there, their cells are looked at. New ones are neighbours in turn.
std::vector<GridTag> TagSearch::add_missed(const cv::Mat1b& image, std::vector<GridTag> found) const {
  for (bool grown = found.size() >= 2; grown;) {
    grown = false;
    for (int number = 0; number < target_.rows * target_.columns; ++number) {
      if (std::any_of(found.begin(), found.end(), [&](const GridTag& t) { return t.number == number; })) continue;
      const auto neighbours = nearest_tags(target_, found, number, kNeighbours);
      const cv::Mat1d H = fit_homography(target_, neighbours);
      if (H.empty()) continue;
      const ImageQuad quad = snap(image, target_, predict(target_, H, number));
      if (!carries_tag(image, number, quad)) continue;
      found.push_back({number, quad});
      grown = true;
    }
  }
  std::sort(found.begin(), found.end(), [](const GridTag& a, const GridTag& b) { return a.number < b.number; });
  return found;
}

std::vector<GridTag> TagSearch::find(const cv::Mat1b& image) const {
  return add_missed(image, keep_consistent(target_, run_library(image)));
}

}  // namespace arpent::calib
