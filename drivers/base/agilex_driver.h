// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Drives an AgileX chassis: every cycle reads what it says and sends what the wheels shall do, zero included. Pure: the
// process around it brings messages and the monotonic clock.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "drivers/base/agilex_v2.h"
#include "drivers/base/command_gate.h"
#include "drivers/base/odometer.h"
#include "drivers/can/can_port.h"

namespace arpent::base {

struct AgilexParams {
  GateParams gate;
  double track_m = 0.583;  ///< effective distance of the sides, for speeds of each
};

struct BaseStatus {
  Time stamp{};  ///< of the last odometry
  double left_m = 0;
  double right_m = 0;
  Twist2 twist;
  double battery_v = 0;
  bool heard = false;           ///< the chassis has reported within the last half second
  bool remote_control = false;  ///< the transmitter has the base; commands are ignored
  bool emergency_stop = false;  ///< the button on the chassis
  std::int64_t bad_frames = 0;
  std::int64_t refused_sends = 0;
};

class AgilexDriver {
 public:
  /// Throws InputError for a track that is not positive.
  AgilexDriver(const AgilexParams& params, can::CanPort& port);

  [[nodiscard]] CommandGate& gate() { return gate_; }
  /// One cycle, every 20 ms: reads all that has come, sends one motion command. Returns what is to be reported, new
  /// faults only.
  std::vector<std::string> step(Time now);
  [[nodiscard]] const BaseStatus& status() const { return status_; }

 private:
  void take(const agilex::SystemState& state, Time now, std::vector<std::string>& faults);
  void take(const agilex::MotionState& state, Time now, std::vector<std::string>& faults);
  void take(const agilex::Odometry& odometry, Time now, std::vector<std::string>& faults);
  void send(const can::CanFrame& frame);

  AgilexParams params_;
  can::CanPort& port_;
  CommandGate gate_;
  BaseStatus status_;
  Odometer left_, right_;
  OdometerFault left_fault_ = OdometerFault::kNone, right_fault_ = OdometerFault::kNone;
  Twist2 commanded_;
  agilex::Mode mode_ = agilex::Mode::kStandby;
  Time heard_at_{};
  bool ever_heard_ = false;
};

}  // namespace arpent::base
