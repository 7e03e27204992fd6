// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What work costs, whatever else the machine does. For figures only: nothing may depend on it.
#pragma once

#include <time.h>

namespace arpent {

/// CPU time of the calling process, all its threads, since its start [s].
[[nodiscard]] inline double process_cpu_s() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace arpent
