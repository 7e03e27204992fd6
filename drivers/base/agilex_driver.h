// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Drives an AgileX chassis: every cycle reads what it says and sends what the wheels shall do, zero included.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/base/agilex_v2.h"
#include "drivers/base/base_driver.h"
#include "drivers/can/can_port.h"

namespace arpent::base {

class AgilexDriver : public BaseDriver {
 public:
  /// `port` must outlive the driver. Throws InputError for parameters that break their rules.
  AgilexDriver(const DriverParams& params, can::CanPort& port);

  std::vector<std::string> step(Time now) override;

 private:
  using Faults = std::vector<std::string>;
  void take(const agilex::SystemState& state, Time stamp, Faults& faults);
  void take(const agilex::MotionState& state, Time stamp, Faults& faults);
  void take(const agilex::Odometry& odometry, Time stamp, Faults& faults);
  void send_motion(const Twist2& twist) override;
  void watch_port(Faults& faults);
  void send(const can::CanFrame& frame);

  can::CanPort& port_;
  can::PortState port_state_ = can::PortState::kActive;
  std::int64_t restarts_ = 0;
  std::optional<agilex::SystemState> last_;
};

}  // namespace arpent::base
