// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "calib/camera_imu_start.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "common/error.h"

namespace arpent::calib::camera_imu {
namespace {

constexpr double kSearchStepS = 0.005;
constexpr double kLeastCorrelation = 0.6;
constexpr double kMostStepS = 0.6;

/// Sum of the gyro's readings over time, which a short turn is about equal to.
Eigen::Vector3d turned(const Readings& readings, double from_s, double to_s) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  readings.walk<double>(from_s, to_s,
                        [&](double dt, const Eigen::Vector3d& turn, const Eigen::Vector3d&) { sum += turn * dt; });
  return sum;
}

/// Of how fast both turn, mean values aside: a number that no mounting changes.
double correlation(const Readings& readings, const std::vector<CameraSample>& camera, double offset_s) {
  double a = 0, b = 0, ab = 0, aa = 0, bb = 0, n = 0;
  for (const Span& span : spans_of(camera, readings, offset_s)) {
    const CameraSample &from = camera[span.from], &to = camera[span.to];
    const double seconds = to.t_s - from.t_s;
    const double x = turn_of(from, to).norm() / seconds;
    const double y = turned(readings, from.t_s + offset_s, to.t_s + offset_s).norm() / seconds;
    a += x, b += y, ab += x * y, aa += x * x, bb += y * y, n += 1;
  }
  if (n < 10) return 0;
  const double variances = (aa - a * a / n) * (bb - b * b / n);
  return variances > 0 ? (ab - a * b / n) / std::sqrt(variances) : 0;
}

}  // namespace

std::vector<Span> spans_of(const std::vector<CameraSample>& camera, const Readings& readings, double offset_s) {
  constexpr double kMarginS = 0.03;  // that the offset may still move
  std::vector<Span> spans;
  for (std::size_t i = 1; i < camera.size(); ++i) {
    const double from_s = camera[i - 1].t_s + offset_s, to_s = camera[i].t_s + offset_s;
    if (to_s - from_s > kMostStepS || !readings.covers(from_s - kMarginS, to_s + kMarginS)) continue;
    spans.push_back({i - 1, i});
  }
  return spans;
}

Eigen::Vector3d turn_of(const CameraSample& a, const CameraSample& b) {
  return so3_log(a.T_ref_cam.linear().transpose() * b.T_ref_cam.linear());
}

Offset search_offset(const Readings& readings, const std::vector<CameraSample>& camera) {
  constexpr double kAsideS = 0.1, kLeastDrop = 0.003;
  double best = 0, best_s = 0;
  const long steps = std::lround(kSearchS / kSearchStepS);
  for (long k = -steps; k <= steps; ++k) {
    const double here = correlation(readings, camera, static_cast<double>(k) * kSearchStepS);
    if (here > best) best = here, best_s = static_cast<double>(k) * kSearchStepS;
  }
  if (best < kLeastCorrelation) {
    throw InputError(
        fmt::format("camera and inertial unit do not turn together (correlation {:.2f}): clocks apart by more than {} "
                    "s, a steady turn that has no beginning or end, or channels of different robots",
                    best, kSearchS));
  }
  const double aside =
      std::max(correlation(readings, camera, best_s - kAsideS), correlation(readings, camera, best_s + kAsideS));
  return {best_s, best - aside >= kLeastDrop};
}

Eigen::Matrix3d align_turns(const CameraImuInput& input, const Readings& readings, const std::vector<Span>& spans,
                            double offset_s) {
  constexpr double kBelief = 1e-3;  // next to what turns say
  Eigen::Matrix3d B = Eigen::Matrix3d::Zero();
  for (const Span& span : spans) {
    const CameraSample &from = input.camera[span.from], &to = input.camera[span.to];
    B += turn_of(from, to) * turned(readings, from.t_s + offset_s, to.t_s + offset_s).transpose();
  }
  B += kBelief * B.norm() * input.T_cam_imu.linear();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

}  // namespace arpent::calib::camera_imu
