// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/coach.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "calib/initial.h"
#include "calib/quality.h"
#include "common/error.h"

namespace arpent::calib {
namespace {

constexpr const char* kTiltNames[] = {"facing the camera", "left edge away", "right edge away", "upper edge away",
                                      "lower edge away"};
/// Of the image's width: good enough to tell which edge is away.
constexpr double kNominalFocal = 0.7;

bool seen(const Corners& corners) {
  return corners.size() >= static_cast<std::size_t>(kMinCorners);
}

/// How far the board has moved between two moments [share of the image's width], by the camera that saw it move most.
double moved(const View& a, const View& b, const std::vector<CameraInput>& cameras) {
  double most = 0;
  bool shared = false;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (c >= a.cameras.size() || !seen(a.cameras[c]) || !seen(b.cameras[c])) continue;
    shared = true;
    most = std::max(most, moved_px(a.cameras[c], b.cameras[c]) / cameras[c].width_px);
  }
  return shared ? most : 1e9;
}

}  // namespace

double moved_px(const Corners& a, const Corners& b) {
  std::map<int, Eigen::Vector2d> before;
  for (const auto& corner : a) before[corner.index] = corner.px;
  double sum = 0, n = 0;
  for (const auto& corner : b) {
    const auto at = before.find(corner.index);
    if (at == before.end()) continue;
    sum += (corner.px - at->second).norm();
    n += 1;
  }
  return n > 0 ? sum / n : 1e9;
}

CaptureCoach::CaptureCoach(const Target& target, const std::vector<CameraInput>& cameras, const CoachParams& params)
    : params_(params), views_{target, cameras, {}} {
  ARPENT_ASSERT(!cameras.empty());
  for (std::size_t c = 0; c < cameras.size(); ++c) coverage_.emplace_back(kCoverageRows, kCoverageColumns, 0.0F);
}

std::string CaptureCoach::offer(const View& view) {
  ARPENT_ASSERT(view.cameras.size() == views_.cameras.size());
  const View before = std::exchange(last_, view);
  if (std::none_of(view.cameras.begin(), view.cameras.end(), seen)) return "no board in sight";
  if (moved(before, view, views_.cameras) > params_.still) return "hold it still";
  const bool known = std::any_of(views_.views.begin(), views_.views.end(), [&](const View& taken) {
    return moved(taken, view, views_.cameras) < params_.different;
  });
  const auto next = [&] {
    const auto list = missing();
    return list.empty() ? std::string("complete") : list.front();
  };
  if (known) return "next: " + next();
  take(view);
  return fmt::format("view {} taken ({}); next: {}", views_.views.size(), kTiltNames[tilt_of(view)], next());
}

void CaptureCoach::take(const View& view) {
  views_.views.push_back(view);
  ++tilts_[tilt_of(view)];
  for (std::size_t c = 0; c < view.cameras.size(); ++c) add_coverage(view.cameras[c], views_.cameras[c], coverage_[c]);
}

/// From a pose by a nominal lens: the board's z axis points at the one who looks.
CaptureCoach::Tilt CaptureCoach::tilt_of(const View& view) const {
  const auto first = std::find_if(view.cameras.begin(), view.cameras.end(), seen);
  const CameraInput& input = views_.cameras[static_cast<std::size_t>(first - view.cameras.begin())];
  RawCamera camera;
  const double f_px = kNominalFocal * input.width_px;
  camera.pinhole = {
      input.width_px, input.height_px, f_px, f_px, 0.5 * (input.width_px - 1), 0.5 * (input.height_px - 1)};
  const RigEstimate rig =
      place_boards_of({views_.target, {input}, {{view.name, {*first}}}}, {{camera}, {Pose::Identity()}, {}});
  const Eigen::Vector3d normal = rig.T_first_board[0].linear().col(2);
  const double sideways = std::asin(std::clamp(normal.x(), -1.0, 1.0)),
               down = std::asin(std::clamp(normal.y(), -1.0, 1.0));
  if (std::max(std::abs(sideways), std::abs(down)) < params_.tilt_rad) return kFacing;
  if (std::abs(sideways) > std::abs(down)) return sideways > 0 ? kRightAway : kLeftAway;
  return down > 0 ? kLowerAway : kUpperAway;
}

double CaptureCoach::coverage_percent(std::size_t camera) const {
  return 100.0 * cv::countNonZero(coverage_[camera]) / static_cast<double>(coverage_[camera].total());
}

std::vector<std::string> CaptureCoach::missing() const {
  std::vector<std::string> list;
  for (std::size_t c = 0; c < coverage_.size(); ++c) {
    if (coverage_percent(c) >= params_.coverage_percent) continue;
    list.push_back(fmt::format("show it in the {} of {} ({:.0f} % covered)", emptiest_part(coverage_[c]),
                               views_.cameras[c].name, coverage_percent(c)));
  }
  for (std::size_t t = 0; t < kTilts; ++t) {
    if (tilts_[t] >= params_.views_per_tilt) continue;
    list.push_back(fmt::format("{} ({} of {} views)", kTiltNames[t], tilts_[t], params_.views_per_tilt));
  }
  // Alternate between where and how: a tilt can be shown in the empty part.
  if (list.size() > 1 && list[0].starts_with("show") && !list.back().starts_with("show")) list[0] += ", " + list.back();
  if (list.empty() && views_.views.size() < params_.views) {
    list.push_back(fmt::format("{} more views anywhere", params_.views - views_.views.size()));
  }
  return list;
}

bool CaptureCoach::complete() const {
  return missing().empty();
}

}  // namespace arpent::calib
