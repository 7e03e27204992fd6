// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Drives a Wifibot board over a serial line, TCP or UDP. Speeds are measured by the odometers: what the board itself
// calls speed has other units on some boards.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "drivers/base/base_driver.h"
#include "drivers/base/byte_port.h"
#include "drivers/base/wifibot.h"

namespace arpent::base {

class WifibotDriver : public BaseDriver {
 public:
  /// `port` must outlive the driver. Throws InputError for parameters that break their rules, and for limits that ask
  /// for more than a command can carry.
  WifibotDriver(const DriverParams& params, const WifibotConfig& config, BytePort& port);

  std::vector<std::string> step(Time now) override;

 private:
  using Faults = std::vector<std::string>;
  void take(const wifibot::Telemetry& telemetry, Time stamp, Faults& faults);
  void take(const wifibot::Stream& stream, Time stamp, Faults& faults);
  void watch_port(Faults& faults);
  void measure_twist();
  void wake(Time now);
  void send_motion(const Twist2& twist) override;
  void send(std::span<const std::uint8_t> bytes);

  WifibotConfig config_;
  BytePort& port_;
  wifibot::Parser parser_;
  bool was_open_ = true;
  std::optional<Time> woken_at_;
  struct Ways {
    Time stamp;
    double left_m, right_m;
  };
  std::deque<Ways> ways_;
};

}  // namespace arpent::base
