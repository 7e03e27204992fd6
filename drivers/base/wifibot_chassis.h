// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A stand-in for a Wifibot board with the manners of its published firmware: it boots streaming in the 0xFE framing and
// turns to the classic one at the first 0xFF, stops after 100 ms without a command, and zeroes its odometers on a PID
// frame. Bytes in, bytes out: whoever owns it has the line.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/time.h"
#include "drivers/base/wheel_motors.h"

namespace arpent::base {

struct WifibotChassisParams {
  MotorParams motors = {};  ///< counts_per_m are the odometers' ticks
  double command_ticks_per_mps = 265.6;
  double battery_v = 12.5;
};

class WifibotChassis {
 public:
  explicit WifibotChassis(const WifibotChassisParams& params) : params_(params), motors_(params.motors) {}

  /// Bytes have come; how many commands were in them.
  int receive(std::span<const std::uint8_t> bytes, Time now);
  void step(Time now, double duration_s);
  /// One telemetry frame, sync byte first.
  [[nodiscard]] std::vector<std::uint8_t> telemetry() const;

  [[nodiscard]] Twist2 twist() const { return motors_.ground_twist(); }
  [[nodiscard]] WheelMotors& motors() { return motors_; }

 private:
  /// Takes one command from the front; the bytes that it or the rubbish there had, 0 if more are needed.
  std::size_t take(std::span<const std::uint8_t> bytes, Time now, int& commands);
  /// A whole command with a right checksum.
  void apply(std::span<const std::uint8_t> frame, Time now);
  void drive(std::uint8_t flags, int left_ticks, int right_ticks, Time now);

  WifibotChassisParams params_;
  WheelMotors motors_;
  std::vector<std::uint8_t> buffer_;
  bool classic_ = false;
  Duration watchdog_{100000};
  int left_ticks_ = 0, right_ticks_ = 0;
  Time commanded_at_{};
};

}  // namespace arpent::base
