// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Visual odometry without images: the true motion from pair to pair, with noise that grows with the way and with the
// turn, and a scale that is a little wrong. For missions that are about planning, not about perception.
#pragma once

#include <cstdint>
#include <random>

#include "common/config/fields.h"
#include "common/geometry.h"
#include "common/pose2.h"

namespace arpent::sim {

/// About what the odometry shows on rendered drives (bench `square`).
struct OdometryNoise {
  double scale = 0.002;
  double translation_m_per_sqrt_m = 0.002;
  double rotation_rad_per_sqrt_rad = 0.001;
  double rotation_rad_per_sqrt_m = 0.0005;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    const auto noise = config::between(0.0, 1.0);
    visitor.field("scale", self.scale, "standard deviation of the scale error, drawn once", noise);
    visitor.field("translation_m_per_sqrt_m", self.translation_m_per_sqrt_m, "position, per root metre", noise);
    visitor.field("rotation_rad_per_sqrt_rad", self.rotation_rad_per_sqrt_rad, "heading, per root radian", noise);
    visitor.field("rotation_rad_per_sqrt_m", self.rotation_rad_per_sqrt_m, "heading, per root metre", noise);
  }
};

struct SimulatedStep {
  Pose T_odom_body = Pose::Identity();
  Matrix6d covariance = Matrix6d::Zero();       ///< accumulated (translation, rotation), body axes
  Matrix6d step_covariance = Matrix6d::Zero();  ///< of this step
};

class SimOdometry {
 public:
  SimOdometry(const OdometryNoise& noise, std::uint64_t seed);
  /// The estimate when the body is truly at `pose`; the first call is the origin.
  [[nodiscard]] SimulatedStep move_to(const Pose2& pose);

 private:
  OdometryNoise noise_;
  std::mt19937_64 random_;
  double scale_ = 1;
  bool started_ = false;
  Pose2 last_;
  SimulatedStep estimate_;
};

}  // namespace arpent::sim
