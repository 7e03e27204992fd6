// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in for an AgileX chassis: its firmware's manners (standby at power-up, half a second until it stops by
// itself, remote control above all, the emergency button, undervoltage) and its motors' lag and slip. The simulator and
// the mock process run it; the driver cannot tell.
#pragma once

#include "drivers/base/agilex_v2.h"
#include "drivers/can/can_port.h"

namespace arpent::base {

struct ChassisParams {
  double track_m = 0.583;
  double lag_s = 0.1;
  double slip = 0.0;  ///< share of the way that the ground does not get: odometers turn, the base does not
  double battery_v = 25.0;
};

class AgilexChassis {
 public:
  AgilexChassis(const ChassisParams& params, can::CanPort& port) : params_(params), port_(port) {}

  /// Moves on by `duration_s` to `now`, at most 20 ms at a time: reads commands, turns the motors, sends reports.
  void step(Time now, double duration_s);

  /// Motion over ground, without slip.
  [[nodiscard]] Twist2 twist() const;
  [[nodiscard]] agilex::Mode mode() const { return mode_; }
  void press_emergency_button(bool pressed) { button_ = pressed; }
  void take_remote_control(bool taken);
  void set_battery_v(double volts) { params_.battery_v = volts; }
  /// Power off and on: standby, counters at zero.
  void restart();

 private:
  void read_commands(Time now);
  void report();

  ChassisParams params_;
  can::CanPort& port_;
  agilex::Mode mode_ = agilex::Mode::kStandby;
  Twist2 command_, wheels_;
  Time commanded_at_{};
  double left_mm_ = 0, right_mm_ = 0;
  bool button_ = false;
  std::uint8_t count_ = 0;
  int cycle_ = 0;
};

}  // namespace arpent::base
