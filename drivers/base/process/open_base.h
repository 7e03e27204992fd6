// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The driver and the port that a robot file asks for, held together.
#pragma once

#include <filesystem>
#include <memory>

#include "common/bus/bus.h"
#include "common/config/robot.h"
#include "drivers/base/base_driver.h"
#include "drivers/base/byte_port.h"
#include "drivers/can/can_port.h"

namespace arpent::base {

struct OpenOptions {
  bool dry_run = false;
  std::filesystem::path can_log;  ///< empty: none
};

class OpenBase {
 public:
  /// Throws InputError for limits, a geometry, a protocol or a port that cannot be used. Bus and clock must outlive it.
  OpenBase(const RobotConfig& robot, const OpenOptions& options, Bus& bus, Clock& clock);

  [[nodiscard]] BaseDriver& driver() { return *driver_; }

 private:
  std::unique_ptr<can::CanPort> can_port_;
  std::unique_ptr<BytePort> byte_port_;
  std::unique_ptr<BaseDriver> driver_;
};

}  // namespace arpent::base
