// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A motor base, whatever it speaks: a gate for commands, one cycle every 20 ms, and what the base says of itself. Pure:
// the process around it brings messages and the monotonic clock; live and lockstep call the same step().
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/config/robot.h"
#include "common/time.h"
#include "common/twist2.h"
#include "drivers/base/command_gate.h"
#include "drivers/base/odometer.h"

namespace arpent::base {

struct DriverParams {
  GateParams gate = {};
  BaseGeometry geometry = {};
  bool dry_run = false;  ///< listens and reports, but sends nothing
};

struct BaseStatus {
  Time stamp{};  ///< of the last odometry
  double left_m = 0;
  double right_m = 0;
  Twist2 twist;      ///< as the base measures it
  Twist2 commanded;  ///< what was sent to it in this cycle
  double battery_v = 0;
  bool heard = false;             ///< the base has reported within the last half second
  bool remote_control = false;    ///< the transmitter has the base; commands are ignored
  bool emergency_button = false;  ///< the button on the chassis is pressed
  std::int64_t bad_frames = 0;    ///< of a wrong size or checksum, or with values that cannot be
  std::int64_t refused_sends = 0;
};

/// How often a base sends and hears.
inline constexpr Duration kCycle{20000};
/// How often a command is looked at for having run out.
inline constexpr Duration kExpiryPeriod{5000};
/// Without a report for so long the base counts as silent.
inline constexpr Duration kSilence{500000};

class BaseDriver {
 public:
  virtual ~BaseDriver() = default;

  [[nodiscard]] CommandGate& gate() { return gate_; }
  [[nodiscard]] const BaseStatus& status() const { return status_; }

  /// One cycle: reads all that has come, sends one motion command, zero included. A port that is lost while armed
  /// latches the emergency stop, a base that falls silent is disarmed: when it comes back it does not start off by
  /// itself. Returns what is to be reported, new faults only.
  virtual std::vector<std::string> step(Time now) = 0;
  /// Latches the emergency stop and sends zero at once, without waiting for the next cycle.
  void stop();
  /// Sends zero at once if the command has run out since the cycle. To be called more often than cycles are: commands
  /// that waited while nobody called it are not carried out.
  void expire(Time now);

 protected:
  /// `unit_m`: way of a side per count of its odometer. `max_speed_mps`: what the base can do at most, in counters that
  /// jump by more. Throws InputError for parameters that break their rules.
  BaseDriver(const DriverParams& params, double unit_m, double max_speed_mps);

  /// Tells the base to move like this, now.
  virtual void send_motion(const Twist2& twist) = 0;
  /// Adds up the ways of both sides and compares them with what they were told.
  void take_odometers(std::int32_t left, std::int32_t right, Time stamp, std::vector<std::string>& faults);
  /// A report has come that proves the base alive.
  void take_sign_of_life(Time now);
  /// The port is lost, or was meanwhile.
  void lose_port();
  /// Judges silence; call once a cycle after all has been read.
  void judge_silence(Time now, std::vector<std::string>& faults);

  CommandGate gate_;
  BaseStatus status_;
  BaseGeometry geometry_;
  bool dry_run_;

 private:
  Odometer left_, right_;
  OdometerFault left_fault_ = OdometerFault::kNone, right_fault_ = OdometerFault::kNone;
  Time heard_at_{};
  bool ever_heard_ = false;
};

}  // namespace arpent::base
