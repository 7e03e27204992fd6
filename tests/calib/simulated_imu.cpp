// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/calib/simulated_imu.h"

#include <array>
#include <cmath>
#include <random>

namespace arpent::calib {
namespace {

constexpr double kDurationS = 20, kImuHz = 200, kCameraHz = 10;
constexpr double kGyroNoise = 2e-3, kForceNoise = 2e-2;

/// A sum of two sines, and its derivatives.
struct Wave {
  std::array<double, 2> amplitude{}, frequency{}, phase{};
  [[nodiscard]] double at(double t, int derivative) const {
    double sum = 0;
    for (std::size_t k = 0; k < 2; ++k)
      sum += amplitude[k] * std::pow(frequency[k], derivative) *
             std::sin(frequency[k] * t + phase[k] + derivative * M_PI / 2);
    return sum;
  }
};

/// The unit's way: place by three waves, attitude by yaw, pitch and roll.
struct Hand {
  std::array<Wave, 3> place, angle;  // x, y, z; roll, pitch, yaw

  Hand(Excitation excitation, std::mt19937& random) {
    std::uniform_real_distribution<double> uniform(0, 1);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < 2; ++k) {
        place[axis].frequency[k] = 2 + 4 * uniform(random);
        place[axis].amplitude[k] = 0.05 + 0.05 * uniform(random);
        place[axis].phase[k] = 2 * M_PI * uniform(random);
        angle[axis].frequency[k] = 2 + 4 * uniform(random);
        angle[axis].amplitude[k] = 0.1 + 0.1 * uniform(random);
        angle[axis].phase[k] = 2 * M_PI * uniform(random);
      }
    }
    if (excitation == Excitation::kLevel) place[2] = angle[0] = angle[1] = {};
  }

  [[nodiscard]] Pose pose(double t) const {
    Pose T = Pose::Identity();
    T.linear() = (Eigen::AngleAxisd(angle[2].at(t, 0), Eigen::Vector3d::UnitZ()) *
                  Eigen::AngleAxisd(angle[1].at(t, 0), Eigen::Vector3d::UnitY()) *
                  Eigen::AngleAxisd(angle[0].at(t, 0), Eigen::Vector3d::UnitX()))
                     .toRotationMatrix();
    T.translation() = Eigen::Vector3d(place[0].at(t, 0), place[1].at(t, 0), place[2].at(t, 0));
    return T;
  }
  /// Body rates of yaw-pitch-roll angles.
  [[nodiscard]] Eigen::Vector3d turn_rate(double t) const {
    const double roll = angle[0].at(t, 0), pitch = angle[1].at(t, 0);
    const double dr = angle[0].at(t, 1), dp = angle[1].at(t, 1), dy = angle[2].at(t, 1);
    return {dr - dy * std::sin(pitch), dp * std::cos(roll) + dy * std::sin(roll) * std::cos(pitch),
            -dp * std::sin(roll) + dy * std::cos(roll) * std::cos(pitch)};
  }
  [[nodiscard]] Eigen::Vector3d force(double t) const {
    const Eigen::Vector3d a(place[0].at(t, 2), place[1].at(t, 2), place[2].at(t, 2) + 9.81);
    return pose(t).linear().transpose() * a;
  }
};

}  // namespace

ImuTruth::ImuTruth() {
  // A unit in body axes behind a camera that looks ahead, a few degrees off.
  T_cam_imu.linear() = R_body_from_camera_axes().transpose() * so3_exp({0.03, -0.05, 0.06});
  T_cam_imu.translation() = Eigen::Vector3d(0.04, 0.06, -0.08);
}

CameraImuInput simulate_imu(const ImuTruth& truth, CameraMotion motion, Excitation excitation, std::uint32_t seed,
                            double camera_noise) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double deviation) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(deviation * x, deviation * y, deviation * z);
  };
  const Hand hand(excitation, random);
  CameraImuInput input;
  input.motion = motion;
  input.T_cam_imu.linear() = R_body_from_camera_axes().transpose();
  input.gyro_noise_radpsrthz = kGyroNoise;
  input.accelerometer_noise_mps2rthz = kForceNoise;
  const Eigen::Vector3d gyro_bias = noise(5e-3), force_bias = noise(5e-2);
  for (int i = 0; i < kDurationS * kImuHz; ++i) {
    const double t_s = i / kImuHz;
    input.imu.push_back({t_s + truth.time_offset_s,
                         hand.turn_rate(t_s) + gyro_bias + noise(kGyroNoise * std::sqrt(kImuHz)),
                         hand.force(t_s) + force_bias + noise(kForceNoise * std::sqrt(kImuHz))});
  }
  const bool poses = motion == CameraMotion::kPoses;
  const double place_m = poses ? 2e-3 : 1e-3, turn_rad = poses ? 1e-3 : 5e-4;
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(place_m * place_m), Eigen::Vector3d::Constant(turn_rad * turn_rad);
  Pose last_true = Pose::Identity(), last_seen = Pose::Identity();
  for (int i = 0; i < kDurationS * kCameraHz; ++i) {
    const double t_s = i / kCameraHz;
    const Pose T = hand.pose(t_s) * truth.T_cam_imu.inverse();
    Vector6d error;
    const Eigen::Vector3d place_error = noise(camera_noise * place_m), turn_error = noise(camera_noise * turn_rad);
    for (int k = 0; k < 3; ++k) error[k] = place_error[k], error[k + 3] = turn_error[k];
    const Pose seen = retract(poses || i == 0 ? T : Pose(last_seen * (last_true.inverse() * T)), error);
    input.camera.push_back({t_s, seen, variances.asDiagonal(), true});
    last_true = T;
    last_seen = seen;
  }
  return input;
}

double rotation_error_rad(const CameraImuCalibration& found, const ImuTruth& truth) {
  return so3_log(truth.T_cam_imu.linear().transpose() * found.T_cam_imu.linear()).norm();
}

}  // namespace arpent::calib
