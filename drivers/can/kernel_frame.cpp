// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/kernel_frame.h"

#include <linux/can/error.h>

#include <algorithm>

namespace arpent::can {
namespace {

/// Where the controller's state stands in an error frame.
constexpr std::size_t kControllerByte = 1;
constexpr std::uint8_t kPassiveBits = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;

}  // namespace

can_frame to_kernel(const CanFrame& frame) {
  can_frame kernel{};
  kernel.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U);
  kernel.can_dlc = frame.size;
  std::copy_n(frame.data.begin(), frame.size, kernel.data);
  return kernel;
}

std::optional<CanFrame> from_kernel(const can_frame& kernel) {
  if ((kernel.can_id & (CAN_ERR_FLAG | CAN_RTR_FLAG)) != 0 || kernel.can_dlc > kMaxBytes) return std::nullopt;
  CanFrame frame;
  frame.extended = (kernel.can_id & CAN_EFF_FLAG) != 0;
  frame.id = kernel.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.size = kernel.can_dlc;
  std::copy_n(kernel.data, frame.size, frame.data.begin());
  return frame;
}

can_frame make_error_frame(PortState state) {
  can_frame frame{};
  frame.can_dlc = CAN_ERR_DLC;
  switch (state) {
    case PortState::kPassive:
      frame.can_id = CAN_ERR_FLAG | CAN_ERR_CRTL;
      frame.data[kControllerByte] = CAN_ERR_CRTL_TX_PASSIVE;
      break;
    case PortState::kBusOff:
    case PortState::kGone:
      frame.can_id = CAN_ERR_FLAG | CAN_ERR_BUSOFF;
      break;
    case PortState::kActive:
      frame.can_id = CAN_ERR_FLAG | CAN_ERR_RESTARTED;
      break;
  }
  return frame;
}

PortState take_error_frame(const can_frame& frame, PortState before, PortCounters& counters) {
  ++counters.error_frames;
  if ((frame.can_id & CAN_ERR_BUSOFF) != 0) return PortState::kBusOff;
  if ((frame.can_id & CAN_ERR_RESTARTED) != 0) {
    if (before == PortState::kBusOff) ++counters.restarts;
    return PortState::kActive;
  }
  if ((frame.can_id & CAN_ERR_CRTL) != 0 && before <= PortState::kPassive) {
    return (frame.data[kControllerByte] & kPassiveBits) != 0 ? PortState::kPassive : PortState::kActive;
  }
  return before;
}

}  // namespace arpent::can
