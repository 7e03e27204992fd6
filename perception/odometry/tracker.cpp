// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "perception/odometry/tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace arpent::odometry {
namespace {

const cv::Size kWindow(15, 15);
/// From picture to picture brightness is counted from its mean in this window, as an automatic exposure changes it. Not
/// between the pictures of a pair, which have one exposure: near edges the mean brings the background along.
const cv::Size kMeanWindow(31, 31);
constexpr double kMidGrey = 128;
constexpr int kMaxLevel = 3;
/// Levels used where the guess is good to a few pixels.
constexpr int kRefineLevel = 1;
/// And where it is good to a pixel.
constexpr int kSubpixelLevel = 0;
const cv::TermCriteria kStop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.03);
constexpr double kMinEigen = 1e-4;
/// Mean absolute difference of the windows [grey levels] above which a track is given up.
constexpr float kMaxDifference = 20.0F;
constexpr double kCornerQuality =
    40.0;  // least eigenvalue of the 5 x 5 structure tensor, squared grey levels per pixel
/// The patch that is searched along the row: 11 rows of 16 pixels, which one vector instruction compares.
constexpr int kPatchHalf = 5;
constexpr int kPatchWidth = 16;
constexpr int kPatchMargin = kPatchWidth / 2;
constexpr float kMaxRowError = 1.0F;

std::vector<std::optional<cv::Point2f>> lucas_kanade(const std::vector<cv::Mat>& from, const std::vector<cv::Mat>& to,
                                                     const std::vector<cv::Point2f>& from_px,
                                                     const std::vector<cv::Point2f>& guess_px, int max_level) {
  std::vector<std::optional<cv::Point2f>> result(from_px.size());
  if (from_px.empty()) return result;
  std::vector<cv::Point2f> found = guess_px;
  std::vector<std::uint8_t> status;
  std::vector<float> difference;
  cv::calcOpticalFlowPyrLK(from, to, from_px, found, status, difference, kWindow, max_level, kStop,
                           cv::OPTFLOW_USE_INITIAL_FLOW, kMinEigen);
  const cv::Rect2f inside(3, 3, static_cast<float>(to[0].cols - 6), static_cast<float>(to[0].rows - 6));
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (status[i] != 0 && difference[i] < kMaxDifference && inside.contains(found[i])) result[i] = found[i];
  }
  return result;
}

int sum_of_differences(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int u_right) {
  int sum = 0;
  for (int dv = -kPatchHalf; dv <= kPatchHalf; ++dv) {
    const std::uint8_t* a = left.ptr(v + dv) + u - kPatchMargin;
    const std::uint8_t* b = right.ptr(v + dv) + u_right - kPatchMargin;
    for (int i = 0; i < kPatchWidth; ++i) sum += std::abs(int{a[i]} - int{b[i]});
  }
  return sum;
}

/// Best whole disparity along the row; nullopt if another one, not beside it, is nearly as good.
std::optional<int> search_row(const cv::Mat1b& left, const cv::Mat1b& right, int u, int v, int max_disparity_px) {
  const int last = std::min(max_disparity_px, u - kPatchMargin);
  std::vector<int> cost;
  for (int d = 0; d <= last; ++d) cost.push_back(sum_of_differences(left, right, u, v, u - d));
  if (cost.empty()) return std::nullopt;
  const auto best = static_cast<int>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  for (int d = 0; d <= last; ++d) {
    if (std::abs(d - best) > 2 && cost[static_cast<std::size_t>(d)] * 10 < cost[static_cast<std::size_t>(best)] * 13) {
      return std::nullopt;
    }
  }
  return best;
}

/// Columns of partners found on the same row and to the left.
std::vector<std::optional<float>> to_columns(const std::vector<std::optional<cv::Point2f>>& found,
                                             const std::vector<cv::Point2f>& left_px) {
  std::vector<std::optional<float>> result(left_px.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] && std::abs(found[i]->y - left_px[i].y) < kMaxRowError && found[i]->x < left_px[i].x - 0.3F) {
      result[i] = found[i]->x;
    }
  }
  return result;
}

std::vector<cv::Point2f> find_corners_at_size(const cv::Mat1b& image, const std::vector<cv::Point2f>& taken_px,
                                              int cell_px, int per_cell) {
  cv::Mat1f quality;
  cv::cornerMinEigenVal(image, quality, 5, 3);
  // cornerMinEigenVal scales 8-bit gradients by 1 / (2^(ksize-1) * block * 255).
  const auto least = static_cast<float>(kCornerQuality / (255.0 * 255.0 * 25.0));
  cv::Mat1f peak;
  cv::dilate(quality, peak, cv::Mat());
  cv::Mat1b blocked(image.size(), std::uint8_t{0});
  const int apart = cell_px / 4;
  for (const auto& p : taken_px) cv::circle(blocked, p, apart, cv::Scalar(255), cv::FILLED);
  const int margin = kPatchMargin / 2 + 1;
  std::vector<cv::Point2f> corners;
  for (int v0 = margin; v0 < image.rows - margin; v0 += cell_px) {
    for (int u0 = margin; u0 < image.cols - margin; u0 += cell_px) {
      const cv::Rect cell(u0, v0, std::min(cell_px, image.cols - margin - u0),
                          std::min(cell_px, image.rows - margin - v0));
      const auto taken =
          std::count_if(taken_px.begin(), taken_px.end(), [&](const auto& p) { return cell.contains(cv::Point(p)); });
      std::vector<std::pair<float, cv::Point>> candidates;
      for (int v = cell.y; v < cell.y + cell.height; ++v) {
        for (int u = cell.x; u < cell.x + cell.width; ++u) {
          const float q = quality(v, u);
          if (q > least && q == peak(v, u) && blocked(v, u) == 0) candidates.emplace_back(q, cv::Point(u, v));
        }
      }
      std::sort(candidates.begin(), candidates.end(), [](const auto& a, const auto& b) {
        return a.first != b.first ? a.first > b.first
                                  : std::pair(a.second.y, a.second.x) < std::pair(b.second.y, b.second.x);
      });
      auto wanted = per_cell - taken;
      for (const auto& [q, p] : candidates) {
        if (wanted <= 0) break;
        if (blocked(p) != 0) continue;
        cv::circle(blocked, p, apart, cv::Scalar(255), cv::FILLED);
        corners.emplace_back(p);
        --wanted;
      }
    }
  }
  return corners;
}

}  // namespace

Pyramid make_pyramid(const cv::Mat1b& image) {
  Pyramid pyramid;
  pyramid.image = image;
  cv::buildOpticalFlowPyramid(image, pyramid.levels, kWindow, kMaxLevel, true);
  return pyramid;
}

Pyramid make_tracked_pyramid(const cv::Mat1b& image) {
  Pyramid pyramid = make_pyramid(image);
  cv::Mat1s mean, deviation;
  cv::boxFilter(image, mean, CV_16S, kMeanWindow, cv::Point(-1, -1), true, cv::BORDER_REFLECT);
  cv::subtract(image, mean, deviation, cv::noArray(), CV_16S);
  cv::Mat1b level;
  deviation.convertTo(level, CV_8U, 1, kMidGrey);
  cv::buildOpticalFlowPyramid(level, pyramid.steady, kWindow, kMaxLevel, true);
  return pyramid;
}

std::vector<std::optional<cv::Point2f>> track_points(const Pyramid& from, const Pyramid& to,
                                                     const std::vector<cv::Point2f>& from_px,
                                                     const std::vector<cv::Point2f>& guess_px) {
  return lucas_kanade(from.steady, to.steady, from_px, guess_px, kMaxLevel);
}

cv::Point2d measure_shift(const cv::Mat1b& from, const cv::Mat1b& to) {
  constexpr double kScale = 0.25;
  cv::Mat1f small[2];
  const cv::Mat1b* images[2] = {&from, &to};
  for (int i = 0; i < 2; ++i) {
    cv::Mat1b shrunk;
    cv::resize(*images[i], shrunk, {}, kScale, kScale, cv::INTER_AREA);
    shrunk.convertTo(small[i], CV_32F);
  }
  cv::Mat1f window;
  cv::createHanningWindow(window, small[0].size(), CV_32F);
  return cv::phaseCorrelate(small[0], small[1], window) / kScale;
}

std::vector<cv::Point2f> find_corners(const Pyramid& pyramid, const std::vector<cv::Point2f>& taken_px, int cell_px,
                                      int per_cell) {
  // At half size: a quarter of the cost, and corners of the size of the windows that follow them (bench `vo`).
  const cv::Mat1b image = pyramid.levels[2];
  std::vector<cv::Point2f> taken;
  for (const auto& p : taken_px) taken.push_back(p / 2);
  std::vector<cv::Point2f> corners = find_corners_at_size(image, taken, cell_px / 2, per_cell);
  for (auto& p : corners) p *= 2;
  return corners;
}

std::vector<std::optional<float>> match_right(const Pyramid& left, const Pyramid& right,
                                              const std::vector<cv::Point2f>& left_px, int max_disparity_px) {
  std::vector<cv::Point2f> searched;
  std::vector<cv::Point2f> guess;
  std::vector<std::size_t> index;
  const int margin = kPatchMargin;
  const cv::Rect inside(margin, margin, left.image.cols - 2 * margin, left.image.rows - 2 * margin);
  for (std::size_t i = 0; i < left_px.size(); ++i) {
    const cv::Point p(cvRound(left_px[i].x), cvRound(left_px[i].y));
    if (!inside.contains(p)) continue;
    const auto d = search_row(left.image, right.image, p.x, p.y, max_disparity_px);
    if (!d) continue;
    searched.push_back(left_px[i]);
    guess.emplace_back(left_px[i].x - static_cast<float>(*d), left_px[i].y);
    index.push_back(i);
  }
  const auto refined = to_columns(lucas_kanade(left.levels, right.levels, searched, guess, kSubpixelLevel), searched);
  std::vector<std::optional<float>> result(left_px.size());
  for (std::size_t i = 0; i < index.size(); ++i) result[index[i]] = refined[i];
  return result;
}

std::vector<std::optional<float>> refine_right(const Pyramid& left, const Pyramid& right,
                                               const std::vector<cv::Point2f>& left_px,
                                               const std::vector<cv::Point2f>& guess_px) {
  return to_columns(lucas_kanade(left.levels, right.levels, left_px, guess_px, kRefineLevel), left_px);
}

}  // namespace arpent::odometry
