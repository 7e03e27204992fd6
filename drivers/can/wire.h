// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages <-> types of CAN: can_frames_t.
#pragma once

#include <arpent/can_frames_t.hpp>
#include <string>
#include <vector>

#include "common/result.h"
#include "common/time.h"
#include "drivers/can/can_frame.h"

namespace arpent::can {

/// Frames that one place sent at one time.
struct SentFrames {
  Time stamp;
  std::string sender;
  std::vector<CanFrame> frames;
};

[[nodiscard]] can_frames_t to_wire(const SentFrames& sent);
/// Checks identifiers, sizes and flags of every frame.
[[nodiscard]] Result<SentFrames> from_wire(const can_frames_t& message);

}  // namespace arpent::can
