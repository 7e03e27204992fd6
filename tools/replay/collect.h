// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What both ways of replaying gather from the bus.
#pragma once

#include "common/bus/bus.h"
#include "common/log/event_log.h"
#include "tools/replay/replay.h"

namespace arpent::tools {

class Collector {
 public:
  /// `log` may be nullptr.
  Collector(ReplayResult& result, LogWriter* log) : result_(result), log_(log) {}
  void take(Time time, const std::string& channel, BytesView bytes);

 private:
  ReplayResult& result_;
  LogWriter* log_;
};

/// Which part of a log is played.
class Window {
 public:
  Window(Time begin, const ReplayOptions& options) : begin_(begin), options_(options) {}
  [[nodiscard]] bool wants(Time time, std::int64_t index) const;

 private:
  Time begin_;
  ReplayOptions options_;
};

}  // namespace arpent::tools
