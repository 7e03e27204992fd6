// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "tests/calib/simulated_drive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "common/pose2.h"
#include "drivers/base/wheel_motors.h"
#include "sim/robot/sim_odometry.h"
#include "sim/robot/sim_robot.h"

namespace arpent::calib {
namespace {

constexpr double kStepS = 0.005;
constexpr int kWheelSteps = 4, kCameraSteps = 40;  // 50 Hz, 5 Hz
constexpr double kDurationS = 120;
constexpr double kTagM = 0.004, kTagRad = 0.002;

Pose mount_of(const DriveTruth& truth) {
  return Pose2{truth.mount_x_m, truth.mount_y_m, truth.mount_yaw_rad}.to_pose() *
         Eigen::AngleAxisd(truth.mount_pitch_rad, Eigen::Vector3d::UnitY());
}

Matrix6d tag_covariance() {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(kTagM * kTagM), Eigen::Vector3d::Constant(kTagRad * kTagRad);
  return variances.asDiagonal();
}

Eigen::Matrix3d planar_part(const Matrix6d& covariance) {
  const std::array<int, 3> kept{0, 1, 5};
  return covariance(kept, kept);
}

/// Slip whose ways add up to `kSlipRootM` per root metre of each side.
void slip(base::WheelMotors& wheels, std::mt19937_64& random) {
  constexpr double kSlipRootM = 0.002;
  std::normal_distribution<double> normal;
  std::array<double, 2> share{};
  for (const base::Side side : {base::Side::kLeft, base::Side::kRight}) {
    const double way_m = std::max(1e-6, std::abs(wheels.speed_mps(side)) * kStepS);
    share[static_cast<std::size_t>(side)] = kSlipRootM * normal(random) / std::sqrt(way_m);
  }
  wheels.set_slip(share[0], share[1]);
}

}  // namespace

DriveInput simulate_drive(const DriveTruth& truth, CameraMotion motion, std::uint32_t seed, bool circle) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  base::MotorParams motors;
  motors.geometry = {truth.track_m, truth.left_scale, truth.right_scale};
  base::WheelMotors wheels(motors);
  sim::SimRobot robot({0, 0, 0.3}, [](const Pose2&) { return false; });
  sim::SimOdometry odometry({}, seed + 1000);
  const Pose T_body_filed = mount_of(truth);
  DriveInput input;
  input.motion = motion;
  input.track_m = 0.39;
  input.step_scale_deviation = sim::OdometryNoise{}.scale;
  Twist2 wanted;
  const int steps = static_cast<int>(kDurationS / kStepS);
  for (int i = 0; i < steps; ++i) {
    if (i % 300 == 0) wanted = {0.3 + 0.2 * uniform(random), 0.9 * uniform(random)};
    if (i % 1200 == 900) wanted.speed_mps = 0;  // turns on the spot
    if (circle) wanted = {0.3, 0.5};
    const double t_s = i * kStepS;
    if (i % kWheelSteps == 0) {
      input.wheels.push_back({t_s + truth.time_offset_s, wheels.count(base::Side::kLeft) / motors.counts_per_m,
                              wheels.count(base::Side::kRight) / motors.counts_per_m});
    }
    if (i % kCameraSteps == 0) {
      const Pose T_world_body = robot.pose().to_pose();
      CameraPose pose{t_s, {}, {}};
      if (motion == CameraMotion::kSteps) {
        // Odometry sees the body turn about the true axis; the file's mounting makes of it the motion of another point.
        const auto seen = odometry.move_to(robot.pose());
        pose.T_ref_body = T_body_filed.inverse() * seen.T_odom_body * T_body_filed;
        pose.covariance = planar_part(seen.step_covariance) + 1e-12 * Eigen::Matrix3d::Identity();
      } else {
        Vector6d error;
        for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? kTagM : kTagRad) * normal(random);
        pose.T_ref_body = retract(T_world_body * T_body_filed, error);
        pose.covariance = planar_part(tag_covariance());
      }
      input.camera.push_back(pose);
    }
    wheels.step(wanted, kStepS);
    slip(wheels, random);
    robot.step(wheels.ground_twist(), kStepS);
  }
  return input;
}

Eigen::Matrix<double, kDriveParameters, 1> error_of(const DriveCalibration& found, const DriveTruth& truth) {
  const Pose2 mount = to_pose2(found.T_body_filed);
  Eigen::Matrix<double, kDriveParameters, 1> error;
  error << found.left_scale - truth.left_scale, found.right_scale - truth.right_scale, found.track_m - truth.track_m,
      found.time_offset_s - truth.time_offset_s, mount.x_m - truth.mount_x_m, mount.y_m - truth.mount_y_m,
      mount.yaw_rad - truth.mount_yaw_rad, 0;
  return error;
}

}  // namespace arpent::calib
