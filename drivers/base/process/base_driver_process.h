// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// base_driver_process: wheel commands in, the motor base driven, its state out at 50 Hz. Starts disarmed. A command
// counts for 200 ms from its receipt by the local clock; its stamp is never looked at. Whatever arrives on ESTOP stops,
// at once and until a BASE_REQUEST releases it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/config/fields.h"

namespace arpent {

struct BaseDriverConfig {
  std::filesystem::path robot;
  std::string port;
  std::filesystem::path can_log;
  bool dry_run = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor& visitor) {
    visitor.field("robot", self.robot, "robot file: limits, protocol, port and geometry of the base",
                  config::required_path());
    visitor.field("port", self.port, "instead of the robot file's; empty: that one");
    visitor.field("can_log", self.can_log, "all CAN frames go to this file too, as from candump -l; empty: no");
    visitor.field("dry_run", self.dry_run, "listen and report, but send nothing to the base");
  }
};

class BaseDriverProcess {
 public:
  using Config = BaseDriverConfig;
  static constexpr char kName[] = "base_driver_process";
  static constexpr char kHelp[] = "Drives the motor base: arming, dead man, emergency stop, odometers.";
  /// Its loop wants SCHED_FIFO and locked memory.
  static constexpr bool kRealTime = true;

  /// Throws InputError for a robot file or a port that cannot be used.
  BaseDriverProcess(const Config& config, Bus& bus, Clock& clock);
  ~BaseDriverProcess();

  /// Disarms: the last thing that the base hears is zero.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace arpent
