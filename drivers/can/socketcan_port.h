// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// A CAN network interface of Linux. Frames carry the kernel's time of arrival; the controller's error frames are heard
// (bus-off, passive, restarted); an interface that is not there or goes away is opened again every 200 ms. A full queue
// (ENOBUFS) refuses the frame: the next cycle's is better than a stale one. Source: the kernel's
// Documentation/networking/can.rst.
#pragma once

#include <linux/can.h>

#include <string>
#include <vector>

#include "drivers/can/can_port.h"
#include "drivers/can/reopening.h"

namespace arpent::can {

class SocketCanPort : public CanPort {
 public:
  /// `heard_ids`: standard identifiers that shall arrive here; empty: all frames.
  SocketCanPort(std::string interface, std::vector<std::uint32_t> heard_ids, Now now);

  bool send(const CanFrame& frame) override;
  std::optional<LoggedFrame> receive() override;
  [[nodiscard]] PortState state() const override { return state_; }
  [[nodiscard]] PortCounters counters() const override { return counters_; }
  [[nodiscard]] std::string fault() const override { return fault_; }

 private:
  void open();
  void give_up(const std::string& reason);
  void lose(int error);
  [[nodiscard]] std::string configure(int fd) const;

  std::string interface_;
  std::vector<std::uint32_t> heard_ids_;
  Now now_;
  FileDescriptor socket_;
  RetryTimer retry_;
  PortState state_ = PortState::kGone;
  PortCounters counters_;
  std::string fault_;
  bool was_open_ = false;
  std::uint32_t kernel_overflows_ = 0;
};

}  // namespace arpent::can
