// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The motors, wheels and encoders of a stand-in chassis: each side follows its command with a lag and a limited
// acceleration, turns an encoder, and slips on the ground. No protocol and no clock: agilex_chassis.h and
// wifibot_chassis.h speak around it.
#pragma once

#include <array>
#include <cstdint>

#include "common/config/robot.h"
#include "common/twist2.h"

namespace arpent::base {

struct MotorParams {
  BaseGeometry geometry = {};  ///< true one; scales stretch the way of a side over what its encoder says
  double lag_s = 0.1;
  double max_acceleration_mps2 = 2.0;  ///< of each side
  /// Share of the way that the ground does not get: encoders turn, the base does not. One-sided slip makes it turn.
  double left_slip = 0.0;
  double right_slip = 0.0;
  double counts_per_m = 1000.0;  ///< of the encoders
  /// Against an obstacle the wheels turn at this share of what they are told.
  double blocked_share = 0.05;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    BaseGeometry::describe(self.geometry, visitor);
    visitor.field("lag_s", self.lag_s, "time constant of the motors", config::between(0.0, 2.0));
    visitor.field("max_acceleration_mps2", self.max_acceleration_mps2, "of each side", config::greater_than(0.0));
    visitor.field("left_slip", self.left_slip, "share of the left way lost on the ground", config::between(0.0, 1.0));
    visitor.field("right_slip", self.right_slip, "share of the right way lost on the ground",
                  config::between(0.0, 1.0));
    visitor.field("counts_per_m", self.counts_per_m, "encoder counts on a metre", config::greater_than(0.0));
    visitor.field("blocked_share", self.blocked_share, "speed against an obstacle over the one wanted",
                  config::between(0.0, 1.0));
  }
};

enum class Side : std::uint8_t { kLeft = 0, kRight = 1 };
enum class EncoderFault : std::uint8_t { kNone, kStuck, kReversed, kDoubled };

class WheelMotors {
 public:
  /// Throws InputError for parameters that break their rules.
  explicit WheelMotors(const MotorParams& params);

  /// Moves on by `duration_s` with the sides wanted at these speeds.
  void step(double left_wanted_mps, double right_wanted_mps, double duration_s);
  /// The same for a twist of the body.
  void step(const Twist2& wanted, double duration_s);

  /// Motion over ground that the wheels make now, after slip. Against an obstacle it is what they strive for (a small
  /// share of the command, with its sign): whoever knows the world withholds the motion, and sees by it when the base
  /// backs out.
  [[nodiscard]] Twist2 ground_twist() const;
  /// What the encoders see.
  [[nodiscard]] Twist2 wheel_twist() const;
  [[nodiscard]] double speed_mps(Side side) const { return speeds_mps_[index(side)]; }
  /// The counter of a side: 32 bits, wrapping.
  [[nodiscard]] std::int32_t count(Side side) const;

  void set_blocked(bool blocked) { blocked_ = blocked; }
  void set_slip(double left, double right);
  void set_encoder_fault(Side side, EncoderFault fault) { faults_[index(side)] = fault; }
  /// Sets a counter, e.g. just before its wrap.
  void set_count(Side side, std::int32_t count) { counts_[index(side)] = count; }
  /// Power off and on: standing, counters at zero.
  void restart();

 private:
  static std::size_t index(Side side) { return static_cast<std::size_t>(side); }
  [[nodiscard]] Twist2 twist(double left_mps, double right_mps) const;

  MotorParams params_;
  bool blocked_ = false;
  std::array<double, 2> speeds_mps_{};
  std::array<double, 2> counts_{};
  std::array<EncoderFault, 2> faults_{};
};

}  // namespace arpent::base
