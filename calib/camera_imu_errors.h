// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Residuals of calib/camera_imu, for doubles and Ceres' dual numbers alike. Only camera_imu.cpp includes this file.
#pragma once

#include <ceres/rotation.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "calib/camera_imu.h"
#include "calib/drive_errors.h"

namespace arpent::calib::camera_imu {

using drive::scalar;
template <class T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <class T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

template <class T>
Matrix3<T> exp_so3(const Vector3<T>& w) {
  Matrix3<T> R;
  ceres::AngleAxisToRotationMatrix(w.data(), R.data());
  return R;
}
template <class T>
Vector3<T> log_so3(const Matrix3<T>& R) {
  Vector3<T> w;
  ceres::RotationMatrixToAngleAxis(R.data(), w.data());
  return w;
}

/// Rotation, velocity and position that the readings add up to, in the unit's axes at the start.
template <class T>
struct Increment {
  Matrix3<T> R = Matrix3<T>::Identity();
  Vector3<T> v = Vector3<T>::Zero(), p = Vector3<T>::Zero();
};

/// Readings as functions of time: straight between samples.
class Readings {
 public:
  explicit Readings(const std::vector<ImuSample>& samples) : samples_(samples) {}

  [[nodiscard]] bool covers(double from_s, double to_s) const {
    constexpr double kMostGapS = 0.1;
    if (from_s < samples_.front().t_s || to_s >= samples_.back().t_s) return false;
    for (std::size_t i = after(from_s); i < samples_.size() && samples_[i - 1].t_s < to_s; ++i) {
      if (samples_[i].t_s - samples_[i - 1].t_s > kMostGapS) return false;
    }
    return true;
  }

  /// Calls step(duration, mean turn rate, mean acceleration) for every piece between the two times.
  template <class T, class Step>
  void walk(const T& from_s, const T& to_s, const Step& step) const {
    Moment<T> last = at(from_s);
    const auto go = [&](const Moment<T>& next) {
      step(T(next.t_s - last.t_s), Vector3<T>(T(0.5) * (last.turn + next.turn)),
           Vector3<T>(T(0.5) * (last.force + next.force)));
      last = next;
    };
    for (std::size_t i = after(scalar(from_s)); i < samples_.size() && samples_[i].t_s < scalar(to_s); ++i) {
      const ImuSample& s = samples_[i];
      go({T(s.t_s), s.angular_velocity_radps.cast<T>(), s.acceleration_mps2.cast<T>()});
    }
    go(at(to_s));
  }

  /// `bias`: of the gyro, then of the accelerometer.
  template <class T>
  Increment<T> integrate(const T& from_s, const T& to_s, const T* bias) const {
    const Vector3<T> gyro_bias(bias[0], bias[1], bias[2]), accelerometer_bias(bias[3], bias[4], bias[5]);
    Increment<T> sum;
    walk(from_s, to_s, [&](const T& dt, const Vector3<T>& turn, const Vector3<T>& force) {
      const Vector3<T> w = (turn - gyro_bias) * dt;
      const Matrix3<T> half = exp_so3<T>(T(0.5) * w);
      const Vector3<T> a = sum.R * (half * (force - accelerometer_bias));
      sum.p += sum.v * dt + T(0.5) * a * dt * dt;
      sum.v += a * dt;
      sum.R = sum.R * half * half;
    });
    return sum;
  }

 private:
  template <class T>
  struct Moment {
    T t_s;
    Vector3<T> turn, force;
  };
  [[nodiscard]] std::size_t after(double t_s) const {
    return static_cast<std::size_t>(std::upper_bound(samples_.begin(), samples_.end(), t_s,
                                                     [](double t, const ImuSample& s) { return t < s.t_s; }) -
                                    samples_.begin());
  }
  template <class T>
  Moment<T> at(const T& t_s) const {
    const std::size_t i = std::clamp<std::size_t>(after(scalar(t_s)), 1, samples_.size() - 1);
    const ImuSample &a = samples_[i - 1], &b = samples_[i];
    const T u = (t_s - a.t_s) / (b.t_s - a.t_s);
    return {t_s,
            a.angular_velocity_radps.cast<T>() + u * (b.angular_velocity_radps - a.angular_velocity_radps).cast<T>(),
            a.acceleration_mps2.cast<T>() + u * (b.acceleration_mps2 - a.acceleration_mps2).cast<T>()};
  }
  const std::vector<ImuSample>& samples_;
};

/// A pose near a known one: `delta` is (translation, rotation), both in the known one's axes.
template <class T>
struct NearPose {
  Matrix3<T> R;
  Vector3<T> p;
  NearPose(const Pose& base, const T* delta) {
    R = base.linear().cast<T>() * exp_so3<T>(Vector3<T>(delta[3], delta[4], delta[5]));
    p = base.translation().cast<T>() + base.linear().cast<T>() * Vector3<T>(delta[0], delta[1], delta[2]);
  }
};

template <int N, class T>
void whiten(const Eigen::Matrix<double, N, N>& W, const Eigen::Matrix<T, N, 1>& error, T* residual) {
  Eigen::Map<Eigen::Matrix<T, N, 1>> out(residual);
  out = W.template cast<T>() * error;
}

/// A measured pose against the estimated one.
struct PoseError {
  Matrix6d W;
  template <class T>
  bool operator()(const T* delta, T* residual) const {
    Eigen::Matrix<T, 6, 1> error;
    for (int i = 0; i < 6; ++i) error[i] = delta[i];
    whiten<6, T>(W, error, residual);
    return true;
  }
};

/// A measured step against the estimated one.
struct StepError {
  Pose from, to;
  Matrix6d W;
  template <class T>
  bool operator()(const T* delta_from, const T* delta_to, T* residual) const {
    const NearPose<T> a(from, delta_from), b(to, delta_to);
    const Pose step = from.inverse() * to;
    Eigen::Matrix<T, 6, 1> error;
    error.template head<3>() =
        step.linear().transpose().cast<T>() * (a.R.transpose() * (b.p - a.p) - step.translation().cast<T>());
    error.template tail<3>() = log_so3<T>(step.linear().transpose().cast<T>() * a.R.transpose() * b.R);
    whiten<6, T>(W, error, residual);
    return true;
  }
};

using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// The readings between two poses. `mount`: turn, place, time offset.
struct ImuError {
  const Readings& readings;
  Pose from, to;
  double from_s, to_s;
  Eigen::Matrix3d R_cam_imu;  ///< that `mount`'s turn is next to
  Matrix9d W;
  template <class T>
  bool operator()(const T* mount, const T* bias, const T* gravity, const T* delta_from, const T* v_from,
                  const T* delta_to, const T* v_to, T* residual) const {
    const NearPose<T> a(from, delta_from), b(to, delta_to);
    const Matrix3<T> R_mount = R_cam_imu.cast<T>() * exp_so3<T>(Vector3<T>(mount[0], mount[1], mount[2]));
    const Vector3<T> place(mount[3], mount[4], mount[5]), g(gravity[0], gravity[1], gravity[2]);
    const Vector3<T> va(v_from[0], v_from[1], v_from[2]), vb(v_to[0], v_to[1], v_to[2]);
    const Matrix3<T> Ra = a.R * R_mount, Rb = b.R * R_mount;
    const Vector3<T> pa = a.p + a.R * place, pb = b.p + b.R * place;
    const Increment<T> sum = readings.integrate<T>(from_s + mount[6], to_s + mount[6], bias);
    const T dt(to_s - from_s);
    Eigen::Matrix<T, 9, 1> error;
    error.template segment<3>(0) = log_so3<T>(sum.R.transpose() * Ra.transpose() * Rb);
    error.template segment<3>(3) = Ra.transpose() * (vb - va - g * dt) - sum.v;
    error.template segment<3>(6) = Ra.transpose() * (pb - pa - va * dt - T(0.5) * g * dt * dt) - sum.p;
    whiten<9, T>(W, error, residual);
    return true;
  }
};

/// Numbers that are known a little; `weight` is shared by all.
template <int N>
struct Prior {
  Eigen::Matrix<double, N, 1> mean, deviation;
  const double& weight;
  template <class T>
  bool operator()(const T* x, T* residual) const {
    for (int i = 0; i < N; ++i) residual[i] = weight * (x[i] - mean[i]) / deviation[i];
    return true;
  }
};

/// Gravity's length.
struct GravityError {
  double length_mps2, deviation_mps2;
  template <class T>
  bool operator()(const T* g, T* residual) const {
    residual[0] = (Vector3<T>(g[0], g[1], g[2]).norm() - length_mps2) / deviation_mps2;
    return true;
  }
};

}  // namespace arpent::calib::camera_imu
