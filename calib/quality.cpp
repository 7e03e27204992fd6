// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/quality.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

namespace arpent::calib {
namespace {

constexpr double kDegrees = 180 / M_PI;

/// What separates good from usable and usable from bad.
struct Limits {
  double usable, bad;
};
constexpr Limits kRmsPx{0.5, 1.5};
constexpr Limits kFocalPercent{0.2, 1.0};
constexpr Limits kUncertaintyPx{0.5, 3.0};
constexpr Limits kHoldout{1.3, 2.0};
constexpr double kGoodCoveragePercent = 70;
constexpr double kGoodTiltDeg = 25, kLeastTiltDeg = 10;
constexpr std::size_t kGoodViews = 15;

void add_coverage(const Calibration& calibration, std::size_t c, CameraQuality& quality) {
  Corners corners;
  for (const Residual& r : calibration.residuals) {
    if (r.observation.camera == static_cast<int>(c)) corners.push_back({r.observation.corner, r.observation.px});
  }
  quality.coverage = cv::Mat1f(kCoverageRows, kCoverageColumns, 0.0F);
  calib::add_coverage(corners, calibration.views.cameras[c], quality.coverage);
  quality.coverage_percent = 100.0 * cv::countNonZero(quality.coverage) / static_cast<double>(quality.coverage.total());
}

/// The camera by itself, from the same start.
double fit_alone(const Calibration& calibration, std::size_t c) {
  RigEstimate rig{{calibration.rig.cameras[c]}, {Pose::Identity()}, {}};
  std::vector<Observation> observations;
  for (std::size_t v = 0; v < calibration.views.views.size(); ++v) {
    rig.T_first_board.push_back(calibration.rig.T_cam_first[c] * calibration.rig.T_first_board[v]);
  }
  for (const Residual& r : calibration.residuals) {
    if (r.observation.camera != static_cast<int>(c)) continue;
    observations.push_back(r.observation);
    observations.back().camera = 0;
  }
  solve(observations, rig, {});
  double squares = 0;
  for (const auto& e : residuals(observations, rig)) squares += e.squaredNorm();
  return std::sqrt(squares / static_cast<double>(observations.size()));
}

CameraQuality assess_camera(const Calibration& calibration, std::size_t c, double rms_px) {
  CameraQuality quality;
  quality.rms_px = rms_px;
  quality.alone_rms_px = calibration.rig.cameras.size() > 1 ? fit_alone(calibration, c) : rms_px;
  add_coverage(calibration, c, quality);
  const auto first = static_cast<Eigen::Index>(kLensParameters * c);
  const PinholeCamera& p = calibration.rig.cameras[c].pinhole;
  quality.focal_deviation_percent =
      100 * std::max(calibration.deviation(first) / p.fx_px, calibration.deviation(first + 1) / p.fy_px);
  if (calibration.covariance.size() == 0) return quality;
  quality.uncertainty_px = projection_uncertainty(
      calibration.rig.cameras[c], calibration.covariance.block(first, first, kLensParameters, kLensParameters));
  double worst = 0;
  cv::minMaxLoc(quality.uncertainty_px, nullptr, &worst);
  quality.worst_uncertainty_px = worst;
  return quality;
}

double largest_tilt_deg(const RigEstimate& rig) {
  double least_cosine = 1;
  for (const Pose& a : rig.T_first_board) {
    for (const Pose& b : rig.T_first_board)
      least_cosine = std::min(least_cosine, a.linear().col(2).dot(b.linear().col(2)));
  }
  return std::acos(std::clamp(least_cosine, -1.0, 1.0)) * kDegrees;
}

/// Distance [px] of corners in camera 1 from the epipolar lines of the same corners in camera 0, both undistorted.
double epipolar_rms(const Calibration& calibration) {
  const RigEstimate& rig = calibration.rig;
  const Eigen::Vector3d t = rig.T_cam_first[1].translation();
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  const Eigen::Matrix3d E = cross * rig.T_cam_first[1].linear();
  const double f_px = 0.5 * (rig.cameras[1].pinhole.fx_px + rig.cameras[1].pinhole.fy_px);
  double squares = 0, n = 0;
  for (const View& view : calibration.views.views) {
    std::map<int, Eigen::Vector2d> first;
    for (const Corner& corner : view.cameras[0]) first[corner.index] = corner.px;
    for (const Corner& corner : view.cameras[1]) {
      const auto match = first.find(corner.index);
      if (match == first.end()) continue;
      const auto a = unproject(rig.cameras[0], match->second), b = unproject(rig.cameras[1], corner.px);
      if (!a || !b) continue;
      const Eigen::Vector3d line = E * a->homogeneous();
      squares += std::pow(b->homogeneous().dot(line) / line.head<2>().norm() * f_px, 2);
      n += 1;
    }
  }
  return n > 0 ? std::sqrt(squares / n) : 0;
}

BoardViews half(const BoardViews& views, std::size_t parity) {
  BoardViews part{views.target, views.cameras, {}};
  for (std::size_t v = parity; v < views.views.size(); v += 2) part.views.push_back(views.views[v]);
  return part;
}

/// Each half fitted, the other predicted.
double holdout_ratio(const Calibration& calibration) {
  if (calibration.views.views.size() < 4 * static_cast<std::size_t>(kMinViews)) return 0;
  double inside = 0, outside = 0;
  for (const std::size_t parity : {0U, 1U}) {
    const BoardViews used = half(calibration.views, parity), other = half(calibration.views, 1 - parity);
    RigEstimate rig = calibration.rig;
    rig.T_first_board.clear();
    for (std::size_t v = parity; v < calibration.views.views.size(); v += 2) {
      rig.T_first_board.push_back(calibration.rig.T_first_board[v]);
    }
    std::vector<Observation> observations;
    for (const Residual& r : calibration.residuals) {
      if (static_cast<std::size_t>(r.observation.view) % 2 != parity) continue;
      observations.push_back(r.observation);
      observations.back().view /= 2;
    }
    solve(observations, rig, {});
    inside += std::pow(rms_of_other_views(rig, used), 2);
    outside += std::pow(rms_of_other_views(rig, other), 2);
  }
  return std::sqrt(outside / inside);
}

class Judge {
 public:
  explicit Judge(Quality& quality) : quality_(quality) {}
  void say(Grade grade, const std::string& sentence) {
    quality_.grade = std::max(quality_.grade, grade);
    const auto at = grade == Grade::kBad ? quality_.advice.begin() + bad_++ : quality_.advice.end();
    quality_.advice.insert(at, sentence);
  }
  void limit(double value, const Limits& limits, const std::string& sentence) {
    if (!(value <= limits.bad)) {
      say(Grade::kBad, sentence);
    } else if (value > limits.usable) {
      say(Grade::kUsable, sentence);
    }
  }

 private:
  Quality& quality_;
  std::ptrdiff_t bad_ = 0;
};

void judge_camera(const CameraQuality& camera, const std::string& name, Judge& judge) {
  judge.limit(
      camera.rms_px, kRmsPx,
      fmt::format("{} misses corners by {:.2f} px: look for blur, a bent board, a wrong target file, or try the other "
                  "lens model",
                  name, camera.rms_px));
  if (camera.rms_px > 2 * camera.alone_rms_px && camera.rms_px > 0.3) {
    judge.say(Grade::kBad,
              fmt::format("{} alone fits to {:.2f} px, with the others only to {:.2f} px: the pictures of a view "
                          "are not of the same moment",
                          name, camera.alone_rms_px, camera.rms_px));
  }
  judge.limit(camera.focal_deviation_percent, kFocalPercent,
              fmt::format("the focal length of {} is known to {:.2f} % only: tilt the board more, and bring it closer",
                          name, camera.focal_deviation_percent));
  judge.limit(camera.worst_uncertainty_px, kUncertaintyPx,
              fmt::format("{} is uncertain by {:.1f} px somewhere in the image: more views near its edges", name,
                          camera.worst_uncertainty_px));
  if (camera.coverage_percent < kGoodCoveragePercent) {
    judge.say(Grade::kUsable, fmt::format("corners cover {:.0f} % of the image of {}: show the board in its {}",
                                          camera.coverage_percent, name, emptiest_part(camera.coverage)));
  }
}

void judge_rig(const Calibration& calibration, const Quality& quality, Judge& judge) {
  if (calibration.rig.cameras.size() == 2) {
    for (const std::string& fault : find_faults(to_stereo(calibration.rig))) judge.say(Grade::kBad, fault);
  }
  if (calibration.covariance.size() == 0)
    judge.say(Grade::kBad, "the views do not determine all parameters: tilt and move the board");
  if (quality.tilt_deg < kLeastTiltDeg) {
    judge.say(Grade::kBad,
              fmt::format("no parallax: the board's views differ by {:.0f} degrees at most, so that focal length and "
                          "distance cannot be told apart; tilt it by 20 to 45 degrees",
                          quality.tilt_deg));
  } else if (quality.tilt_deg < kGoodTiltDeg) {
    judge.say(Grade::kUsable,
              fmt::format("the board was tilted by {:.0f} degrees at most: 30 and more are better", quality.tilt_deg));
  }
  if (calibration.views.views.size() < kGoodViews) {
    judge.say(Grade::kUsable, fmt::format("{} views: take {} or more", calibration.views.views.size(), kGoodViews));
  }
  if (quality.holdout_ratio > 0) {
    judge.limit(quality.holdout_ratio, kHoldout,
                fmt::format("one half of the views predicts the other {:.2f} times worse than itself: take more views",
                            quality.holdout_ratio));
  }
}

}  // namespace

void add_coverage(const Corners& corners, const CameraInput& camera, cv::Mat1f& coverage) {
  for (const Corner& corner : corners) {
    const int column = static_cast<int>(corner.px.x() / camera.width_px * kCoverageColumns);
    const int row = static_cast<int>(corner.px.y() / camera.height_px * kCoverageRows);
    coverage(std::clamp(row, 0, kCoverageRows - 1), std::clamp(column, 0, kCoverageColumns - 1)) += 1;
  }
}

std::string emptiest_part(const cv::Mat1f& coverage) {
  static constexpr const char* kNames[3][3] = {{"upper left", "upper middle", "upper right"},
                                               {"left", "middle", "right"},
                                               {"lower left", "lower middle", "lower right"}};
  double least = 2;
  std::string name;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const cv::Range rows(r * kCoverageRows / 3, (r + 1) * kCoverageRows / 3);
      const cv::Range columns(c * kCoverageColumns / 3, (c + 1) * kCoverageColumns / 3);
      const cv::Mat part = coverage(rows, columns);
      const double covered = cv::countNonZero(part) / static_cast<double>(part.total());
      if (covered < least) least = covered, name = kNames[r][c];
    }
  }
  return name;
}

const char* to_text(Grade grade) {
  return grade == Grade::kGood ? "good" : grade == Grade::kUsable ? "usable" : "bad";
}

cv::Mat1f projection_uncertainty(const RawCamera& camera, const Eigen::MatrixXd& covariance) {
  constexpr int kFields = kCoverageRows * kCoverageColumns;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2 * kFields, kLensParameters), G = Eigen::MatrixXd::Zero(2 * kFields, 3);
  const LensParameters lens = to_parameters(camera);
  const auto seen = [&](const LensParameters& l, const Eigen::Vector3d& p) {
    Eigen::Vector2d px(0, 0);
    project(camera.distortion, l.data(), p.data(), px.data());
    return px;
  };
  std::vector<bool> valid;
  for (int i = 0; i < kFields; ++i) {
    const Eigen::Vector2d px((i % kCoverageColumns + 0.5) * camera.pinhole.width_px / kCoverageColumns,
                             (i / kCoverageColumns + 0.5) * camera.pinhole.height_px / kCoverageRows);
    const auto plane = unproject(camera, px);
    valid.push_back(plane.has_value());
    if (!plane) continue;
    const Eigen::Vector3d p = plane->homogeneous();
    for (int k = 0; k < kLensParameters; ++k) {
      const double h = 1e-5 * std::max(1.0, std::abs(lens[static_cast<std::size_t>(k)]));
      LensParameters more = lens, less = lens;
      more[static_cast<std::size_t>(k)] += h;
      less[static_cast<std::size_t>(k)] -= h;
      J.block<2, 1>(2 * i, k) = (seen(more, p) - seen(less, p)) / (2 * h);
    }
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d w = 1e-6 * Eigen::Vector3d::Unit(k);
      G.block<2, 1>(2 * i, k) = (seen(lens, p + w.cross(p)) - seen(lens, p - w.cross(p))) / 2e-6;
    }
  }
  const Eigen::MatrixXd turned = G * (G.transpose() * G).ldlt().solve(G.transpose() * J);
  const Eigen::MatrixXd left = J - turned;
  cv::Mat1f map(kCoverageRows, kCoverageColumns, 0.0F);
  for (int i = 0; i < kFields; ++i) {
    const auto rows = left.middleRows(2 * i, 2);
    const double variance = (rows * covariance * rows.transpose()).trace() / 2;
    if (valid[static_cast<std::size_t>(i)])
      map(i / kCoverageColumns, i % kCoverageColumns) = static_cast<float>(std::sqrt(variance));
  }
  return map;
}

Quality assess(const Calibration& calibration) {
  Quality quality;
  const auto rms_px = rms_by_camera(calibration);
  for (std::size_t c = 0; c < rms_px.size(); ++c) quality.cameras.push_back(assess_camera(calibration, c, rms_px[c]));
  quality.tilt_deg = largest_tilt_deg(calibration.rig);
  if (rms_px.size() > 1) quality.epipolar_rms_px = epipolar_rms(calibration);
  quality.holdout_ratio = holdout_ratio(calibration);
  Judge judge(quality);
  for (std::size_t c = 0; c < rms_px.size(); ++c)
    judge_camera(quality.cameras[c], calibration.views.cameras[c].name, judge);
  judge_rig(calibration, quality, judge);
  return quality;
}

}  // namespace arpent::calib
