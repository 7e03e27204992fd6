// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/robot/sim_imu.h"

#include <cmath>

namespace arpent::sim {
namespace {

constexpr double kGravityMps2 = 9.80665;

}  // namespace

SimImu::SimImu(const ImuNoise& noise, std::uint64_t seed)
    : noise_(noise),
      random_(seed),
      gyro_bias_(draw(noise.gyro_bias_radps)),
      accelerometer_bias_(draw(noise.accelerometer_bias_mps2)) {}

Eigen::Vector3d SimImu::draw(double deviation) {
  std::normal_distribution<double> normal;
  const double x = normal(random_);
  const double y = normal(random_);
  const double z = normal(random_);
  return deviation * Eigen::Vector3d(x, y, z);
}

ImuReading SimImu::read(const Twist2& twist, double duration_s) {
  const double root = std::sqrt(duration_s);
  gyro_bias_ += draw(noise_.gyro_walk_radps2rthz * root);
  const double acceleration = (twist.speed_mps - last_speed_mps_.value_or(twist.speed_mps)) / duration_s;
  last_speed_mps_ = twist.speed_mps;
  ImuReading reading;
  reading.angular_velocity_radps =
      Eigen::Vector3d(0, 0, twist.turn_rate_radps) + gyro_bias_ + draw(noise_.gyro_noise_radpsrthz / root);
  reading.acceleration_mps2 = Eigen::Vector3d(acceleration, twist.speed_mps * twist.turn_rate_radps, kGravityMps2) +
                              accelerometer_bias_ + draw(noise_.accelerometer_noise_mps2rthz / root);
  return reading;
}

}  // namespace arpent::sim
