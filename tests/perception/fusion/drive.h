// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A drive on the plane with known truth, and what wheels, gyro and visual odometry would say about it, with noise of
// known size and faults on demand. For the tests and the benchmark of the fused pose; it shares no code with the
// filter.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <vector>

#include "common/pose2.h"
#include "perception/fusion/pose_fusion.h"

namespace arpent::fusion {

struct DriveParams {
  unsigned seed = 1;
  double duration_s = 40;
  double distance_scale = 0;  ///< true way = (1 + scale) * odometers' way
  double track_m = 0.583;
  double wheel_noise_m_per_sqrt_m = 0.01;
  double wheel_noise_rad_per_sqrt_rad = 0.05;
  double sideways_noise_m_per_sqrt_m = 0.005;
  double gyro_bias_radps = 0;
  double gyro_noise_radps_per_sqrt_hz = 0.002;
  double odometry_sigma_m = 0.003;
  double odometry_sigma_rad = 0.001;
  /// Changes what a sensor says; time is since the start.
  std::function<void(double t_s, WheelReading&)> wheel_fault = [](double, WheelReading&) {};
  std::function<void(double t_s, OdometryReading&)> odometry_fault = [](double, OdometryReading&) {};
  /// Speed and turn rate wanted.
  std::function<Twist2(double t_s)> profile = {};
};

/// Stands for 3 s, then winds along at 0.5 m/s; turns on the spot for 2 s in every 15 s.
inline Twist2 winding(double t_s) {
  if (t_s < 3) return {};
  if (std::fmod(t_s, 15) > 13) return {0, 0.8};
  return {0.5, 0.6 * std::sin(0.7 * t_s)};
}

struct Drive {
  std::vector<WheelReading> wheels;       // 50 Hz
  std::vector<GyroReading> gyro;          // 100 Hz
  std::vector<OdometryReading> odometry;  // 5 Hz
  std::map<Time, Pose> truth;             // 100 Hz, in odom
};

inline Drive make_drive(const DriveParams& p) {
  constexpr double kStepS = 0.01;
  const Time start = from_utime(100000000);
  std::mt19937 random(p.seed);
  std::normal_distribution<double> normal;
  Drive drive;
  Pose truth = Pose::Identity(), truth_before = truth, T_vo = truth;
  double left_m = 1, right_m = 2, way_m = 0, turn_rad = 0;
  Twist2 twist;
  for (int i = 0; i * kStepS <= p.duration_s; ++i) {
    const double t_s = i * kStepS;
    const Time stamp = start + from_seconds(t_s);
    const Twist2 wanted = p.profile ? p.profile(t_s) : winding(t_s);
    if (i > 0) {
      // The base follows within its acceleration, evenly over the step.
      const Twist2 before = twist;
      twist.speed_mps += std::clamp(wanted.speed_mps - twist.speed_mps, -0.01, 0.01);
      twist.turn_rate_radps += std::clamp(wanted.turn_rate_radps - twist.turn_rate_radps, -0.03, 0.03);
      const double d = 0.5 * (before.speed_mps + twist.speed_mps) * kStepS;
      const double a = 0.5 * (before.turn_rate_radps + twist.turn_rate_radps) * kStepS;
      const double sideways = p.sideways_noise_m_per_sqrt_m * std::sqrt(std::abs(d)) * normal(random);
      Pose step = Pose::Identity();
      step.linear() = Eigen::AngleAxisd(a, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      step.translation() << d * std::cos(a / 2) - sideways * std::sin(a / 2),
          d * std::sin(a / 2) + sideways * std::cos(a / 2), 0;
      truth = truth * step;
      way_m += d / (1 + p.distance_scale) + p.wheel_noise_m_per_sqrt_m * std::sqrt(std::abs(d)) * normal(random);
      turn_rad += a + p.wheel_noise_rad_per_sqrt_rad * std::sqrt(std::abs(a)) * normal(random);
    }
    drive.truth[stamp] = truth;
    drive.gyro.push_back({stamp, twist.turn_rate_radps + p.gyro_bias_radps +
                                     p.gyro_noise_radps_per_sqrt_hz / std::sqrt(kStepS) * normal(random)});
    if (i % 2 == 0) {
      left_m += way_m - 0.5 * p.track_m * turn_rad;
      right_m += way_m + 0.5 * p.track_m * turn_rad;
      way_m = turn_rad = 0;
      WheelReading reading{stamp, left_m, right_m, wanted, true};
      p.wheel_fault(t_s, reading);
      drive.wheels.push_back(reading);
    }
    if (i % 20 == 0) {
      Vector6d noise;
      for (int k = 0; k < 6; ++k) noise(k) = (k < 3 ? p.odometry_sigma_m : p.odometry_sigma_rad) * normal(random);
      OdometryReading reading;
      reading.stamp = stamp;
      reading.sequence = i / 20;
      reading.usable = reading.anchored = true;
      if (i > 0) {
        T_vo = retract(T_vo * (truth_before.inverse() * truth), noise);
        reading.step_covariance.diagonal() << Eigen::Vector3d::Constant(std::pow(p.odometry_sigma_m, 2)),
            Eigen::Vector3d::Constant(std::pow(p.odometry_sigma_rad, 2));
      }
      truth_before = truth;
      reading.T_odom_body = T_vo;
      p.odometry_fault(t_s, reading);
      drive.odometry.push_back(reading);
    }
  }
  return drive;
}

/// A reading of any kind, due at the fusion at `at`.
struct Delivery {
  Time at;
  std::function<std::string(PoseFusion&)> add;
};

/// Wheels and gyro come at once, odometry `delay` later.
inline std::vector<Delivery> deliveries(const Drive& drive, Duration delay = std::chrono::milliseconds(130)) {
  std::vector<Delivery> all;
  for (const auto& r : drive.gyro) all.push_back({r.stamp, [r](PoseFusion& f) { return f.add(r); }});
  for (const auto& r : drive.wheels) all.push_back({r.stamp, [r](PoseFusion& f) { return f.add(r); }});
  for (const auto& r : drive.odometry) all.push_back({r.stamp + delay, [r](PoseFusion& f) { return f.add(r); }});
  std::stable_sort(all.begin(), all.end(), [](const Delivery& a, const Delivery& b) { return a.at < b.at; });
  return all;
}

/// Feeds all and returns the estimates at the odometry's times, each as it was when that odometry came (PAIR_POSE).
inline std::vector<FusedPose> run(PoseFusion& fusion, const Drive& drive,
                                  Duration delay = std::chrono::milliseconds(130)) {
  std::vector<FusedPose> poses;
  const auto all = deliveries(drive, delay);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].add(fusion), "");
    // The odometry of a moment comes after what else comes then.
    const bool last_of_moment = i + 1 == all.size() || all[i + 1].at > all[i].at;
    const bool odometry_came =
        poses.size() < drive.odometry.size() && all[i].at == drive.odometry[poses.size()].stamp + delay;
    if (last_of_moment && odometry_came) poses.push_back(*fusion.at(drive.odometry[poses.size()].stamp));
  }
  return poses;
}

inline Vector6d error(const FusedPose& pose, const Drive& drive) {
  return local(pose.T_frame_body, drive.truth.at(pose.stamp));
}

inline double rms_m(const std::vector<FusedPose>& poses, const Drive& drive) {
  double squares = 0;
  for (const FusedPose& pose : poses) squares += error(pose, drive).head<2>().squaredNorm();
  return std::sqrt(squares / static_cast<double>(poses.size()));
}

inline double worst_m(const std::vector<FusedPose>& poses, const Drive& drive) {
  double worst = 0;
  for (const FusedPose& pose : poses) worst = std::max(worst, error(pose, drive).head<2>().norm());
  return worst;
}

/// The odometry's own poses.
inline std::vector<FusedPose> odometry_alone(const Drive& drive) {
  std::vector<FusedPose> poses;
  for (const OdometryReading& o : drive.odometry) {
    poses.emplace_back();
    poses.back().stamp = o.stamp;
    poses.back().T_frame_body = o.T_odom_body;
  }
  return poses;
}

/// Normalised squared error in (x, y, yaw): 3 on average if the covariance is honest.
inline double planar_nees(const FusedPose& pose, const Drive& drive) {
  constexpr int kPlanar[] = {0, 1, 5};
  const Vector6d e = error(pose, drive);
  Eigen::Vector3d planar;
  Eigen::Matrix3d P;
  for (int r = 0; r < 3; ++r) {
    planar(r) = e(kPlanar[r]);
    for (int c = 0; c < 3; ++c) P(r, c) = pose.covariance(kPlanar[r], kPlanar[c]);
  }
  return planar.dot(P.llt().solve(planar));
}

/// A drive whose unknown scale and bias are drawn as the default parameters say.
inline DriveParams drawn(unsigned seed) {
  std::mt19937 random(1000 + seed);
  std::normal_distribution<double> normal;
  DriveParams p;
  p.seed = seed;
  p.distance_scale = 0.02 * normal(random);
  p.gyro_bias_radps = 0.05 * normal(random);
  return p;
}

}  // namespace arpent::fusion
