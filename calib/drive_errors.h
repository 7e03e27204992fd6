// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Residuals of calib/drive, for doubles and Ceres' dual numbers alike: what wheels say of a step (an interpolated,
// differentiable in time, sum of arcs) against what the camera says. Only drive.cpp includes this file.
#pragma once

#include <ceres/jet.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "calib/drive.h"
#include "common/pose2.h"

namespace arpent::calib::drive {

inline double scalar(double x) {
  return x;
}
template <class T, int N>
double scalar(const ceres::Jet<T, N>& x) {
  return x.a;
}

template <class T>
using Planar = std::array<T, 3>;  ///< x, y [m], yaw [rad]

template <class T>
Planar<T> compose(const Planar<T>& a, const Planar<T>& b) {
  using std::cos;
  using std::sin;
  const T c = cos(a[2]), s = sin(a[2]);
  return {a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]};
}
template <class T>
Planar<T> inverse(const Planar<T>& a) {
  using std::cos;
  using std::sin;
  const T c = cos(a[2]), s = sin(a[2]);
  return {-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]};
}
inline Planar<double> planar(const Pose& T) {
  const Pose2 p = to_pose2(T);
  return {p.x_m, p.y_m, p.yaw_rad};
}

class Ways {
 public:
  explicit Ways(const std::vector<WheelWays>& samples) : samples_(samples) {}

  [[nodiscard]] bool covers(double from_s, double to_s) const {
    if (from_s < samples_.front().t_s || to_s >= samples_.back().t_s) return false;
    for (std::size_t i = after(from_s); i < samples_.size() && samples_[i - 1].t_s < to_s; ++i) {
      if (samples_[i].t_s - samples_[i - 1].t_s > 0.2) return false;
    }
    return true;
  }

  /// (left, right) by the cubic B-spline over the samples; differentiable by the time. It evens out the encoders'
  /// counts alike at and between samples; a straight line does so only in between, and draws the delay there.
  template <class T>
  std::array<T, 2> at(const T& t_s) const {
    const std::size_t i = std::clamp<std::size_t>(after(scalar(t_s)), 1, samples_.size() - 1);
    const double period_s = samples_[i].t_s - samples_[i - 1].t_s;
    const T u = (t_s - samples_[i - 1].t_s) / period_s, v = 1.0 - u;
    const std::array<T, 4> weight{v * v * v / 6.0, (3.0 * u * u * (u - 2.0) + 4.0) / 6.0,
                                  (3.0 * v * v * (v - 2.0) + 4.0) / 6.0, u * u * u / 6.0};
    T left(0), right(0), time_s(0);
    for (std::size_t k = 0; k < weight.size(); ++k) {
      const std::size_t j = std::clamp<std::size_t>(i + k, 2, samples_.size() + 1) - 2;
      left += weight[k] * samples_[j].left_m;
      right += weight[k] * samples_[j].right_m;
      time_s += weight[k] * (samples_[j].t_s - samples_[i - 1].t_s);
    }
    // Where samples are not evenly spaced, the spline's time is not quite the one asked for.
    const T late = (t_s - samples_[i - 1].t_s - time_s) / period_s;
    return {left + late * (samples_[i].left_m - samples_[i - 1].left_m),
            right + late * (samples_[i].right_m - samples_[i - 1].right_m)};
  }

  /// Motion of the body between two times: arcs from sample to sample.
  template <class T>
  Planar<T> step(const T& from_s, const T& to_s, const T* q) const {
    Planar<T> pose{T(0), T(0), T(0)};
    std::array<T, 2> last = at(from_s);
    const auto go = [&](const std::array<T, 2>& next) {
      using std::cos;
      using std::sin;
      const T left = q[kLeftScale] * (next[0] - last[0]), right = q[kRightScale] * (next[1] - last[1]);
      const T way = 0.5 * (left + right), turn = (right - left) / q[kTrack];
      const T heading = pose[2] + 0.5 * turn;
      const T chord = way * (1.0 - turn * turn / 24.0);
      pose = {pose[0] + chord * cos(heading), pose[1] + chord * sin(heading), pose[2] + turn};
      last = next;
    };
    for (std::size_t i = after(scalar(from_s)); i < samples_.size() && samples_[i].t_s < scalar(to_s); ++i) {
      go(at(T(samples_[i].t_s)));
    }
    go(at(to_s));
    return pose;
  }

 private:
  [[nodiscard]] std::size_t after(double t_s) const {
    return static_cast<std::size_t>(std::upper_bound(samples_.begin(), samples_.end(), t_s,
                                                     [](double t, const WheelWays& w) { return t < w.t_s; }) -
                                    samples_.begin());
  }
  const std::vector<WheelWays>& samples_;
};

/// Two camera poses with wheels in between.
struct Span {
  std::size_t from, to;
  double from_s, to_s;
  Planar<double> seen;         ///< the step, by the filed mounting
  Eigen::Matrix3d covariance;  ///< of the camera's step; for poses unused
  Eigen::Matrix3d wheels;      ///< of the wheels' step, body axes
};

template <class T>
void whiten(const Eigen::Matrix3d& W, const Planar<T>& error, T* residual) {
  for (int r = 0; r < 3; ++r) {
    residual[r] = T(0);
    for (int c = 0; c <= r; ++c) residual[r] += W(r, c) * error[static_cast<std::size_t>(c)];
  }
}

/// A step of the camera's odometry against the wheels.
struct StepError {
  const Ways& ways;
  Span span;
  Eigen::Matrix3d W;
  template <class T>
  bool operator()(const T* q, T* residual) const {
    const Planar<T> mount{q[kMountX], q[kMountY], q[kMountYaw]};
    const Planar<T> step = ways.step<T>(span.from_s + q[kTimeOffset], span.to_s + q[kTimeOffset], q);
    const Planar<T> expected = compose(compose(inverse(mount), step), mount);
    const T scale = q[kStepScale];
    whiten(W, {scale * expected[0] - span.seen[0], scale * expected[1] - span.seen[1], expected[2] - span.seen[2]},
           residual);
    return true;
  }
};

/// The wheels between two poses of the body.
struct WheelError {
  const Ways& ways;
  Span span;
  Eigen::Matrix3d W;
  template <class T>
  bool operator()(const T* q, const T* from, const T* to, T* residual) const {
    const Planar<T> step = ways.step<T>(span.from_s + q[kTimeOffset], span.to_s + q[kTimeOffset], q);
    const Planar<T> moved = compose(inverse(Planar<T>{from[0], from[1], from[2]}), Planar<T>{to[0], to[1], to[2]});
    whiten(W, {moved[0] - step[0], moved[1] - step[1], moved[2] - step[2]}, residual);
    return true;
  }
};

/// A pose that the camera sees, against the body's.
struct PoseError {
  Planar<double> seen;
  Eigen::Matrix3d W;
  template <class T>
  bool operator()(const T* q, const T* pose, T* residual) const {
    const Planar<T> mount{q[kMountX], q[kMountY], q[kMountYaw]};
    const Planar<T> filed = compose(Planar<T>{pose[0], pose[1], pose[2]}, mount);
    Planar<T> error = compose(inverse(Planar<T>{T(seen[0]), T(seen[1]), T(seen[2])}), filed);
    error[2] -= 2 * M_PI * std::round(scalar(error[2]) / (2 * M_PI));
    whiten(W, error, residual);
    return true;
  }
};

/// What is thinkable on a robot, and what is known of the odometry's scale; `weight` is shared by all.
struct PriorError {
  std::array<double, kDriveParameters> start, deviation;
  const double& weight;
  template <class T>
  bool operator()(const T* q, T* residual) const {
    for (std::size_t k = 0; k < start.size(); ++k) residual[k] = weight * (q[k] - start[k]) / deviation[k];
    return true;
  }
};

}  // namespace arpent::calib::drive
