// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The real base_driver_process in front of a stand-in chassis on a local socket, timed from messages to CAN frames.
#pragma once

#include "bench/harness.h"

namespace arpent::bench {

/// Adds deadman.p99_ms (random stops of a stream of commands, until the first zero frame) and estop.p99_ms (from the
/// stop's message to its frame, with four busy loops; SCHED_FIFO at both ends, else it says that it is skipped).
void time_live_base(Report& report);

}  // namespace arpent::bench
