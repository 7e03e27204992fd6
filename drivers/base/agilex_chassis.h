// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in for an AgileX chassis: its firmware's manners (standby at power-up, half a second until it stops by
// itself, remote control above all, the emergency button, undervoltage) around motors (wheel_motors.h). The simulator
// and the mock process run it; the driver cannot tell.
#pragma once

#include "drivers/base/agilex_v2.h"
#include "drivers/base/wheel_motors.h"
#include "drivers/can/can_port.h"

namespace arpent::base {

struct ChassisParams {
  MotorParams motors = {};
  double battery_v = 25.0;
};

class AgilexChassis {
 public:
  /// `port` must outlive the chassis. Throws InputError for parameters that break their rules.
  AgilexChassis(const ChassisParams& params, can::CanPort& port);

  /// Moves on by `duration_s` to `now`, in steps of 1 to 20 ms: reads commands, turns the motors, and sends a report
  /// every 20 ms.
  void step(Time now, double duration_s);

  /// Motion over ground; see WheelMotors::ground_twist for what it means against an obstacle.
  [[nodiscard]] Twist2 twist() const { return motors_.ground_twist(); }
  /// Contact with the world holds the base.
  void set_blocked(bool blocked) { motors_.set_blocked(blocked); }
  /// For slip and encoder faults.
  [[nodiscard]] WheelMotors& motors() { return motors_; }
  [[nodiscard]] agilex::Mode mode() const { return mode_; }

  void press_emergency_button(bool pressed) { button_ = pressed; }
  /// The transmitter takes the base and drives it at `sticks`, or gives it back (to standby).
  void take_remote_control(bool taken, const Twist2& sticks = {});
  void set_battery_v(double volts) { battery_v_ = volts; }
  /// Power off and on: standby, counters at zero.
  void restart();

 private:
  void read_commands(Time now);
  [[nodiscard]] Twist2 wanted(Time now) const;
  void report();

  can::CanPort& port_;
  WheelMotors motors_;
  double battery_v_;
  agilex::Mode mode_ = agilex::Mode::kStandby;
  Twist2 command_, sticks_;
  Time commanded_at_{};
  Time report_due_{};
  bool button_ = false;
  std::uint8_t count_ = 0;
  int cycle_ = 0;
};

}  // namespace arpent::base
