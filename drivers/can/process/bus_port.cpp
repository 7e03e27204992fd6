// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/process/bus_port.h"

#include <utility>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "drivers/can/wire.h"

namespace arpent::can {
namespace {

/// Messages and frames that may wait for the next cycle; both sides send one message in 20 ms.
constexpr int kMessages = 64;
constexpr std::size_t kFrames = 1024;

}  // namespace

BusPort::BusPort(std::string place, Bus& bus, Clock& clock) : place_(std::move(place)), bus_(bus), clock_(clock) {
  SubscriptionOptions options;
  options.queue_capacity = kMessages;
  options.max_bytes = 65536;
  subscribe<can_frames_t>(bus, channels::kCan, options, [this](const can_frames_t& message) {
    const auto sent = from_wire(message);
    if (!sent) {
      bus_.health().count(channels::kCan, "invalid");
      bus_.health().warn("CAN message dropped: " + sent.fault());
      return;
    }
    if (sent->sender == place_) return;
    for (const CanFrame& frame : sent->frames) {
      if (arrived_.size() >= kFrames) {
        ++counters_.overflows;
        continue;
      }
      arrived_.push_back({clock_.now(), sent->sender, frame});
    }
  });
}

bool BusPort::send(const CanFrame& frame) {
  sending_.push_back(frame);
  return true;
}

void BusPort::flush() {
  if (sending_.empty()) return;
  publish(bus_, channels::kCan, to_wire({clock_.now(), place_, std::exchange(sending_, {})}));
}

std::optional<LoggedFrame> BusPort::receive() {
  if (arrived_.empty()) return std::nullopt;
  LoggedFrame frame = std::move(arrived_.front());
  arrived_.pop_front();
  return frame;
}

}  // namespace arpent::can
