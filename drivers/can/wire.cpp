// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/wire.h"

#include <algorithm>

namespace arpent::can {

can_frames_t to_wire(const SentFrames& sent) {
  can_frames_t message{};
  message.utime = to_utime(sent.stamp);
  message.sender = sent.sender;
  message.count = static_cast<std::int32_t>(sent.frames.size());
  for (const CanFrame& frame : sent.frames) {
    can_frame_t wire{};
    wire.id = static_cast<std::int32_t>(frame.id);
    wire.extended = frame.extended ? 1 : 0;
    wire.size = static_cast<std::int8_t>(frame.size);
    std::copy(frame.data.begin(), frame.data.end(), wire.data);
    message.frames.push_back(wire);
  }
  return message;
}

Result<SentFrames> from_wire(const can_frames_t& message) {
  SentFrames sent{from_utime(message.utime), message.sender, {}};
  for (const can_frame_t& wire : message.frames) {
    if (wire.extended != 0 && wire.extended != 1) return Fault{"a frame is neither standard nor extended"};
    const std::int32_t most = wire.extended != 0 ? kLargestExtendedId : kLargestStandardId;
    if (wire.id < 0 || wire.id > most) return Fault{"a frame's identifier is out of range"};
    if (wire.size < 0 || wire.size > static_cast<std::int8_t>(kMaxBytes)) return Fault{"a frame's size is not 0 to 8"};
    CanFrame frame;
    frame.id = static_cast<std::uint32_t>(wire.id);
    frame.extended = wire.extended != 0;
    frame.size = static_cast<std::uint8_t>(wire.size);
    std::copy_n(wire.data, frame.size, frame.data.begin());
    sent.frames.push_back(frame);
  }
  return sent;
}

}  // namespace arpent::can
