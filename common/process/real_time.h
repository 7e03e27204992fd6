// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Real-time scheduling for the few processes whose lateness moves or stops wheels.
#pragma once

#include <optional>
#include <string>

namespace arpent {

/// SCHED_FIFO for the calling thread and the threads that it starts from now on, and all memory locked. The reason if
/// the system does not allow it (docs/robots.md says how it can).
[[nodiscard]] std::optional<std::string> enter_real_time();

}  // namespace arpent
