// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/process/real_time.h"

#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace arpent {
namespace {

/// Above the kernel's threaded interrupts (50), below its watchdogs (99).
constexpr int kPriority = 80;

}  // namespace

std::optional<std::string> enter_real_time() {
  sched_param parameters{};
  parameters.sched_priority = kPriority;
  if (sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
    return std::string("no real-time scheduling: ") + std::strerror(errno);
  }
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) return std::string("memory is not locked: ") + std::strerror(errno);
  return std::nullopt;
}

}  // namespace arpent
