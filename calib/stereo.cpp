// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/stereo.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calib/initial.h"
#include "common/error.h"

namespace arpent::calib {
namespace {

/// The median length of a Gaussian 2-vector is this times its deviation per coordinate.
constexpr double kMedianLength = 1.17741;
constexpr double kCornerSigmas = 6;   // of 100 000 good corners, one in a thousand runs is lost
constexpr double kViewFactor = 4;     // a view whose typical error is so many times that of all views
constexpr double kLeastViewPx = 0.3;  // views better than this are never called bad
constexpr double kLeastSigmaPx = 1e-3;
constexpr int kRejectionRounds = 3;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double rms(const std::vector<double>& lengths) {
  double sum = 0;
  for (const double l : lengths) sum += l * l;
  return lengths.empty() ? 0 : std::sqrt(sum / static_cast<double>(lengths.size()));
}

/// Lengths of the errors by (view, camera).
std::vector<std::vector<std::vector<double>>> lengths_by_view(const std::vector<Observation>& observations,
                                                              const RigEstimate& rig) {
  std::vector<std::vector<std::vector<double>>> lengths(rig.T_first_board.size(),
                                                        std::vector<std::vector<double>>(rig.cameras.size()));
  const auto errors = residuals(observations, rig);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const auto& o = observations[i];
    lengths[static_cast<std::size_t>(o.view)][static_cast<std::size_t>(o.camera)].push_back(errors[i].norm());
  }
  return lengths;
}

/// Noise that a robust fit shows [px per coordinate].
double robust_sigma(const std::vector<Observation>& observations, const RigEstimate& rig) {
  std::vector<double> lengths;
  for (const auto& e : residuals(observations, rig)) lengths.push_back(e.norm());
  return std::max(median(lengths) / kMedianLength, kLeastSigmaPx);
}

/// Takes bad views and bad corners out of `views` (view numbers stay). True if any was taken.
bool reject(BoardViews& views, const RigEstimate& rig, Calibration& result) {
  const auto observations = to_observations(views);
  const double sigma_px = robust_sigma(observations, rig);
  const auto lengths = lengths_by_view(observations, rig);
  const auto errors = residuals(observations, rig);
  bool any = false;
  std::size_t at = 0;
  for (std::size_t v = 0; v < views.views.size(); ++v) {
    for (std::size_t c = 0; c < views.cameras.size(); ++c) {
      Corners& corners = views.views[v].cameras[c];
      if (corners.empty()) continue;
      const double typical_px = median(lengths[v][c]) / kMedianLength;
      if (typical_px > std::max(kViewFactor * sigma_px, kLeastViewPx)) {
        result.rejected_views.push_back({views.views[v].name, views.cameras[c].name, rms(lengths[v][c])});
        at += corners.size();
        corners.clear();
        any = true;
        continue;
      }
      Corners kept;
      for (const Corner& corner : corners) {
        if (errors[at++].norm() <= kCornerSigmas * sigma_px) kept.push_back(corner);
      }
      if (kept.size() == corners.size()) continue;
      result.rejected_corners += static_cast<int>(corners.size() - kept.size());
      if (kept.size() < static_cast<std::size_t>(kMinCorners)) {
        result.rejected_views.push_back({views.views[v].name, views.cameras[c].name, rms(lengths[v][c])});
        kept.clear();
      }
      corners = kept;
      any = true;
    }
  }
  return any;
}

RigEstimate starting_point(const BoardViews& views, const CalibrationParams& params) {
  if (!params.start) return initial_estimate(views, params.model);
  ARPENT_ASSERT(params.start->cameras.size() == views.cameras.size());
  return place_boards_of(views, *params.start);
}

/// Views without any corner left are no views; numbers move up.
void drop_empty_views(BoardViews& views, RigEstimate& rig) {
  BoardViews kept{views.target, views.cameras, {}};
  std::vector<Pose> boards;
  for (std::size_t v = 0; v < views.views.size(); ++v) {
    const auto& cameras = views.views[v].cameras;
    if (std::all_of(cameras.begin(), cameras.end(), [](const Corners& c) { return c.empty(); })) continue;
    kept.views.push_back(std::move(views.views[v]));
    boards.push_back(rig.T_first_board[v]);
  }
  views = std::move(kept);
  rig.T_first_board = std::move(boards);
}

void add_statistics(Calibration& result) {
  const auto observations = to_observations(result.views);
  const auto errors = residuals(observations, result.rig);
  double squares = 0;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    squares += errors[i].squaredNorm();
    result.residuals.push_back({observations[i], errors[i]});
  }
  const auto n = static_cast<double>(errors.size());
  const double unknowns = kLensParameters * static_cast<double>(result.rig.cameras.size()) +
                          6 * static_cast<double>(result.rig.cameras.size() - 1 + result.views.views.size());
  result.rms_px = std::sqrt(squares / n);
  result.sigma_px = std::sqrt(squares / std::max(2 * n - unknowns, 1.0));
  result.covariance = result.sigma_px * result.sigma_px * unit_covariance(observations, result.rig);
}

}  // namespace

double Calibration::deviation(Eigen::Index parameter) const {
  if (covariance.size() == 0) return std::numeric_limits<double>::infinity();
  return std::sqrt(covariance(parameter, parameter));
}

double Calibration::baseline_m(std::size_t camera) const {
  return rig.T_cam_first[camera].translation().norm();
}

double Calibration::baseline_deviation_m(std::size_t camera) const {
  if (covariance.size() == 0) return std::numeric_limits<double>::infinity();
  const Eigen::Vector3d along = rig.T_cam_first[camera].translation().normalized();
  const Eigen::Index i = mount_index(camera);
  return std::sqrt(along.dot(covariance.block<3, 3>(i, i) * along));
}

Calibration calibrate(const BoardViews& input, const CalibrationParams& params) {
  Calibration result;
  BoardViews views = usable_views(input);
  RigEstimate rig = starting_point(views, params);
  if (params.reject_outliers) {
    for (int round = 0; round < kRejectionRounds; ++round) {
      const double scale_px = 2 * std::max(robust_sigma(to_observations(views), rig), 0.05);
      solve(to_observations(views), rig, {.cauchy_px = scale_px});
      if (!reject(views, rig, result)) break;
    }
  }
  drop_empty_views(views, rig);
  result.views = usable_views(views);
  solve(to_observations(result.views), rig, {});
  result.rig = rig;
  add_statistics(result);
  return result;
}

std::vector<std::vector<std::optional<double>>> rms_by_view(const Calibration& calibration) {
  std::vector<std::vector<std::optional<double>>> table;
  for (const auto& view : lengths_by_view(to_observations(calibration.views), calibration.rig)) {
    auto& row = table.emplace_back();
    for (const auto& lengths : view) row.push_back(lengths.empty() ? std::nullopt : std::optional(rms(lengths)));
  }
  return table;
}

std::vector<double> rms_by_camera(const Calibration& calibration) {
  std::vector<std::vector<double>> lengths(calibration.rig.cameras.size());
  for (const Residual& r : calibration.residuals) {
    lengths[static_cast<std::size_t>(r.observation.camera)].push_back(r.error_px.norm());
  }
  std::vector<double> all;
  for (const auto& l : lengths) all.push_back(rms(l));
  return all;
}

double rms_of_other_views(const RigEstimate& rig, const BoardViews& views) {
  RigEstimate placed = place_boards_of(views, rig);
  const auto observations = to_observations(views);
  solve(observations, placed, {.fix_cameras = true});
  std::vector<double> lengths;
  for (const auto& e : residuals(observations, placed)) lengths.push_back(e.norm());
  return rms(lengths);
}

StereoCalibration to_stereo(const RigEstimate& rig) {
  ARPENT_ASSERT(rig.cameras.size() >= 2);
  StereoCalibration stereo;
  stereo.left = rig.cameras[0];
  stereo.right = rig.cameras[1];
  stereo.T_right_left = rig.T_cam_first[1];
  return stereo;
}

}  // namespace arpent::calib
