// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/process/open_base.h"

#include "drivers/base/agilex_driver.h"
#include "drivers/base/wifibot_driver.h"
#include "drivers/can/candump.h"
#include "drivers/can/process/open_can_port.h"

namespace arpent::base {

OpenBase::OpenBase(const RobotConfig& robot, const OpenOptions& options, Bus& bus, Clock& clock) {
  const DriverParams params{{.limits = robot.limits}, robot.base.geometry, options.dry_run};
  if (robot.base.protocol == "wifibot") {
    byte_port_ = open_byte_port(robot.base.port, [&clock] { return clock.now(); });
    driver_ = std::make_unique<WifibotDriver>(params, robot.base.wifibot, *byte_port_);
    return;
  }
  can_port_ = can::open_can_port(robot.base.port, "driver", bus, clock,
                                 {agilex::kSystemStateId, agilex::kMotionStateId, agilex::kOdometryId});
  if (!options.can_log.empty()) {
    can_port_ =
        std::make_unique<can::RecordingPort>(std::move(can_port_), options.can_log, [&clock] { return clock.now(); });
  }
  driver_ = std::make_unique<AgilexDriver>(params, *can_port_);
}

}  // namespace arpent::base
