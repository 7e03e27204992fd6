// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A CAN bus on the robot's own bus: frames travel as can_frames_t on channel CAN, so that lockstep missions are
// deterministic and every frame stands in the mission's log. All places on one robot's bus hear each other.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "common/bus/bus.h"
#include "drivers/can/can_port.h"

namespace arpent::can {

class BusPort : public CanPort {
 public:
  /// `place`: the sender's name in messages, e.g. "driver"; what comes from the same name is not heard. Bus and clock
  /// must outlive the port; it subscribes, so it is made before the executor runs.
  BusPort(std::string place, Bus& bus, Clock& clock);
  BusPort(const BusPort&) = delete;
  BusPort& operator=(const BusPort&) = delete;

  bool send(const CanFrame& frame) override;
  void flush() override;
  std::optional<LoggedFrame> receive() override;
  [[nodiscard]] PortState state() const override { return PortState::kActive; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }

 private:
  std::string place_;
  Bus& bus_;
  Clock& clock_;
  std::vector<CanFrame> sending_;
  std::deque<LoggedFrame> arrived_;
  PortCounters counters_;
};

}  // namespace arpent::can
