// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Messages of a simulated drive or motion, into a log.
#pragma once

#include <gtest/gtest.h>

#include "common/bus/typed.h"
#include "common/log/event_log.h"

namespace arpent::tools {

/// Moments of the log begin long after the epoch.
inline Time at(double t_s) {
  return Time(std::chrono::seconds(1000) + from_seconds(t_s));
}

template <class Message>
void write(LogWriter& log, double t_s, const char* channel, const Message& message) {
  ASSERT_TRUE(log.write(at(t_s), channel, encode(message)));
}

}  // namespace arpent::tools
