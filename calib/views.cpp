// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "common/error.h"

namespace arpent::calib {
namespace {

/// Sum of squared distances [px^2] that the best homography leaves.
double homography_misfit(const Target& target, const Corners& corners) {
  std::vector<cv::Point2d> board, image, mapped;
  for (const Corner& c : corners) {
    const Eigen::Vector2d p = target.corner_m(c.index);
    board.emplace_back(p.x(), p.y());
    image.emplace_back(c.px.x(), c.px.y());
  }
  const cv::Mat H = cv::findHomography(board, image);
  if (H.empty()) return 1e12;
  cv::perspectiveTransform(board, mapped, H);
  double sum = 0;
  for (std::size_t i = 0; i < image.size(); ++i) sum += (mapped[i] - image[i]).dot(mapped[i] - image[i]);
  return sum;
}

/// The corner lists with the most corners: distortion bends all alike, so a few are enough.
std::vector<const Corners*> fullest(const BoardViews& views, std::size_t count) {
  std::vector<const Corners*> lists;
  for (const View& view : views.views) {
    for (const Corners& corners : view.cameras) {
      if (corners.size() >= static_cast<std::size_t>(kMinCorners)) lists.push_back(&corners);
    }
  }
  std::stable_sort(lists.begin(), lists.end(), [](auto* a, auto* b) { return a->size() > b->size(); });
  if (lists.size() > count) lists.resize(count);
  return lists;
}

double spacing_rms(const std::vector<const Corners*>& lists, Target target, double ratio) {
  target.spacing_ratio = ratio;
  double sum = 0, n = 0;
  for (const Corners* corners : lists) {
    sum += homography_misfit(target, *corners);
    n += static_cast<double>(corners->size());
  }
  return std::sqrt(sum / std::max(n, 1.0));
}

void require_enough_views(const BoardViews& views) {
  for (std::size_t c = 0; c < views.cameras.size(); ++c) {
    const auto n =
        std::count_if(views.views.begin(), views.views.end(), [&](const View& v) { return !v.cameras[c].empty(); });
    if (n < kMinViews) {
      throw InputError(
          fmt::format("too few views: {} sees the board in {} of them, and {} is the least (20 or more, tilted, "
                      "all over the image, is good)",
                      views.cameras[c].name, n, kMinViews));
    }
    const auto shared = std::count_if(views.views.begin(), views.views.end(), [&](const View& v) {
      return !v.cameras[c].empty() &&
             std::count_if(v.cameras.begin(), v.cameras.end(), [](const Corners& k) { return !k.empty(); }) > 1;
    });
    if (views.cameras.size() > 1 && shared == 0) {
      throw InputError(
          fmt::format("{} never sees the board together with another camera: are the pairs named alike, and are "
                      "the clocks the same?",
                      views.cameras[c].name));
    }
  }
}

void require_true_spacing(const BoardViews& views) {
  const SpacingCheck check = check_spacing(views);
  const double stated = views.target.spacing_ratio;
  if (check.stated_rms_px < 2 * check.seen_rms_px || std::abs(check.seen_ratio / stated - 1) < 0.05) return;
  throw InputError(
      fmt::format("wrong spacing: the target file says tagSpacing {:g}, the pictures show about {:.3f} (misfit {:.1f} "
                  "px against {:.1f} "
                  "px); it is the gap over the tag's size, not metres",
                  stated, check.seen_ratio, check.stated_rms_px, check.seen_rms_px));
}

}  // namespace

SpacingCheck check_spacing(const BoardViews& views) {
  constexpr std::size_t kLists = 4;
  constexpr int kRatios = 60;
  const auto lists = fullest(views, kLists);
  SpacingCheck check{views.target.spacing_ratio, 0, spacing_rms(lists, views.target, views.target.spacing_ratio)};
  check.seen_rms_px = check.stated_rms_px;
  for (int i = 0; i < kRatios; ++i) {
    const double ratio = 0.02 * std::pow(50.0, i / (kRatios - 1.0));
    const double rms_px = spacing_rms(lists, views.target, ratio);
    if (rms_px < check.seen_rms_px) check.seen_ratio = ratio, check.seen_rms_px = rms_px;
  }
  return check;
}

BoardViews usable_views(const BoardViews& input) {
  BoardViews usable{input.target, input.cameras, {}};
  for (View view : input.views) {
    ARPENT_ASSERT(view.cameras.size() == input.cameras.size());
    bool any = false;
    for (Corners& corners : view.cameras) {
      if (corners.size() < static_cast<std::size_t>(kMinCorners)) corners.clear();
      any |= !corners.empty();
    }
    if (any) usable.views.push_back(std::move(view));
  }
  require_enough_views(usable);
  if (usable.target.kind == TargetKind::kAprilGrid) require_true_spacing(usable);
  return usable;
}

}  // namespace arpent::calib
