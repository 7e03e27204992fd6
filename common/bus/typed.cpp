// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/bus/typed.h"

#include <time.h>

#include <exception>

#include "common/wire_schema.h"

namespace arpent::detail {
namespace {

double thread_cpu_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

}  // namespace

std::string guard(const char* type, BytesView bytes) {
  return wire_schema().check(type, bytes).value_or("");
}

void count_gap(Health& health, const std::string& channel, std::int64_t& last, std::int64_t sequence) {
  if (last >= 0 && sequence > last + 1) health.count(channel, "lost", sequence - last - 1);
  last = sequence;
}

void run_handler(Health& health, const std::string& channel, const std::function<void()>& handle) {
  const double start_ms = thread_cpu_ms();
  try {
    handle();
    health.count(channel, "handled");
  } catch (const std::exception& error) {
    health.count(channel, "failed");
    health.error(channel + ": " + error.what());
  }
  health.add_handler_ms(channel, thread_cpu_ms() - start_ms);
}

}  // namespace arpent::detail
