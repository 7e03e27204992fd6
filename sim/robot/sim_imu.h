// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The inertial unit of a simulated body: what gyro and accelerometer read on level ground, with biases drawn at the
// start, their random walk, and white noise.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <random>

#include "common/config/fields.h"
#include "common/twist2.h"

namespace arpent::sim {

/// Noise of a small MEMS unit.
struct ImuNoise {
  double gyro_noise_radpsrthz = 2e-3;
  double gyro_bias_radps = 5e-3;
  double gyro_walk_radps2rthz = 2e-5;
  double accelerometer_noise_mps2rthz = 2e-2;
  double accelerometer_bias_mps2 = 5e-2;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("gyro_noise_radpsrthz", self.gyro_noise_radpsrthz, "white noise of the gyro [rad/s/sqrt(Hz)]",
                  config::at_least(0.0));
    visitor.field("gyro_bias_radps", self.gyro_bias_radps, "standard deviation of the gyro's bias at the start",
                  config::at_least(0.0));
    visitor.field("gyro_walk_radps2rthz", self.gyro_walk_radps2rthz, "random walk of that bias [rad/s^2/sqrt(Hz)]",
                  config::at_least(0.0));
    visitor.field("accelerometer_noise_mps2rthz", self.accelerometer_noise_mps2rthz,
                  "white noise of the accelerometer [m/s^2/sqrt(Hz)]", config::at_least(0.0));
    visitor.field("accelerometer_bias_mps2", self.accelerometer_bias_mps2,
                  "standard deviation of the accelerometer's bias", config::at_least(0.0));
  }
};

struct ImuReading {
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_mps2 = Eigen::Vector3d::Zero();  ///< specific force
};

class SimImu {
 public:
  SimImu(const ImuNoise& noise, std::uint64_t seed);
  /// The reading at the end of `duration_s` (> 0) in which the body has come to move with `twist`; body axes.
  [[nodiscard]] ImuReading read(const Twist2& twist, double duration_s);

 private:
  [[nodiscard]] Eigen::Vector3d draw(double deviation);

  ImuNoise noise_;
  std::mt19937_64 random_;
  Eigen::Vector3d gyro_bias_, accelerometer_bias_;
  std::optional<double> last_speed_mps_;
};

}  // namespace arpent::sim
