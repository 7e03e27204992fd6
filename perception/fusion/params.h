// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What the fused pose believes of its inputs: the noise of wheels and gyro, what motions are possible, and when to
// stop.
#pragma once

#include "common/config/fields.h"

namespace arpent::fusion {

/// Deviations of random walks grow with the root of the way: over d metres it is `noise * sqrt(d)`.
struct WheelParams {
  double track_m = 0.583;
  double noise_m_per_sqrt_m = 0.01;
  double sideways_noise_m_per_sqrt_m = 0.005;
  double noise_rad_per_sqrt_m = 0.02;
  double noise_rad_per_sqrt_rad = 0.05;
  double noise_m_per_sqrt_rad = 0.01;
  double distance_scale_sigma = 0.02;
  double turn_scale_sigma = 0.1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    const auto noise = config::between(0.0, 1.0);
    visitor.field("track_m", self.track_m, "effective distance of the sides", config::between(0.05, 5.0));
    visitor.field("noise_m_per_sqrt_m", self.noise_m_per_sqrt_m, "along the heading, per root metre", noise);
    visitor.field("sideways_noise_m_per_sqrt_m", self.sideways_noise_m_per_sqrt_m, "across it", noise);
    visitor.field("noise_rad_per_sqrt_m", self.noise_rad_per_sqrt_m, "of the wheels' turn, per root metre", noise);
    visitor.field("noise_rad_per_sqrt_rad", self.noise_rad_per_sqrt_rad, "of the wheels' turn, per root radian", noise);
    visitor.field("noise_m_per_sqrt_rad", self.noise_m_per_sqrt_rad, "shift that a turn brings, per root radian",
                  noise);
    visitor.field("distance_scale_sigma", self.distance_scale_sigma, "deviation of the wheels' scale at the start",
                  noise);
    visitor.field("turn_scale_sigma", self.turn_scale_sigma, "deviation of the track's scale at the start", noise);
  }
};

struct GyroParams {
  bool used = true;
  double noise_radps_per_sqrt_hz = 0.002;
  double bias_sigma_radps = 0.05;
  double bias_walk_radps_per_sqrt_s = 0.0001;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("used", self.used, "false: the robot has none, wheels alone give the turn");
    visitor.field("noise_radps_per_sqrt_hz", self.noise_radps_per_sqrt_hz, "density of its noise",
                  config::between(1e-6, 1.0));
    visitor.field("bias_sigma_radps", self.bias_sigma_radps, "deviation of the bias at the start",
                  config::between(0.0, 1.0));
    visitor.field("bias_walk_radps_per_sqrt_s", self.bias_walk_radps_per_sqrt_s, "random walk of the bias",
                  config::between(0.0, 0.1));
  }
};

/// Roll, pitch and height revert to the ground plane as the robot moves: a weak prior.
struct GroundParams {
  double sigma_m = 0.05;
  double sigma_rad = 0.03;
  double reach_m = 2.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("sigma_m", self.sigma_m, "deviation of the height from the plane", config::between(1e-4, 10.0));
    visitor.field("sigma_rad", self.sigma_rad, "deviation of roll and pitch", config::between(1e-4, 1.0));
    visitor.field("reach_m", self.reach_m, "way after which the ground has another slope",
                  config::between(0.1, 1000.0));
  }
};

struct OdometryTrust {
  double max_speed_mps = 1.5;
  double max_acceleration_mps2 = 3.0;
  double max_turn_rate_radps = 3.0;
  double max_turn_acceleration_radps2 = 6.0;
  double gate_sigmas = 4.0;
  double timeout_s = 0.6;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("max_speed_mps", self.max_speed_mps, "a step that is faster is a jump of the odometry",
                  config::greater_than(0.0));
    visitor.field("max_acceleration_mps2", self.max_acceleration_mps2, "the same for its acceleration",
                  config::greater_than(0.0));
    visitor.field("max_turn_rate_radps", self.max_turn_rate_radps, "the same for its turn rate",
                  config::greater_than(0.0));
    visitor.field("max_turn_acceleration_radps2", self.max_turn_acceleration_radps2, "the same for the rate's change",
                  config::greater_than(0.0));
    visitor.field("gate_sigmas", self.gate_sigmas, "more deviations between wheels and odometry are slip",
                  config::between(2.0, 20.0));
    visitor.field("timeout_s", self.timeout_s, "without odometry for longer: dead reckoning",
                  config::between(0.1, 60.0));
  }
};

struct TagParams {
  bool used = true;
  double floor_m = 0.03;
  double floor_rad = 0.05;
  double spacing_m = 0.1;
  double spacing_rad = 0.1;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("used", self.used, "tags seen after the alignment correct the drift");
    visitor.field("floor_m", self.floor_m, "deviation added to a tag's position: what repeats from view to view",
                  config::between(0.0, 1.0));
    visitor.field("floor_rad", self.floor_rad, "the same for its rotation, of which little is believed",
                  config::between(0.0, 1.0));
    visitor.field("spacing_m", self.spacing_m, "way between two views that count as two", config::at_least(0.0));
    visitor.field("spacing_rad", self.spacing_rad, "or turn between them", config::at_least(0.0));
  }
};

struct FusionParams {
  WheelParams wheels;
  GyroParams gyro;
  GroundParams ground;
  OdometryTrust odometry;
  TagParams tags;
  double max_dead_reckoning_m = 0.25;
  double max_dead_reckoning_rad = 0.25;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.group("wheels", self.wheels, "odometers of the two sides");
    visitor.group("gyro", self.gyro, "yaw rate");
    visitor.group("ground", self.ground, "the ground plane");
    visitor.group("odometry", self.odometry, "what is believed of visual odometry");
    visitor.group("tags", self.tags, "tags after the alignment");
    visitor.field("max_dead_reckoning_m", self.max_dead_reckoning_m,
                  "lost when the deviation since the last odometry is beyond this", config::greater_than(0.0));
    visitor.field("max_dead_reckoning_rad", self.max_dead_reckoning_rad, "the same for the heading",
                  config::greater_than(0.0));
  }
};

}  // namespace arpent::fusion
