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
  /// `log` may be nullptr. `running`: the processes whose outputs count as the replay's own.
  Collector(ReplayResult& result, LogWriter* log, const std::set<std::string>& running) : result_(result), log_(log) {
    for (const std::string& process : running) {
      for (const std::string& channel : outputs_of(process)) replayed_.insert(channel);
    }
  }
  void take(Time time, const std::string& channel, BytesView bytes);

 private:
  ReplayResult& result_;
  LogWriter* log_;
  std::set<std::string> replayed_;
};

/// Which part of a log is played. What comes before the first pair belongs to the beginning.
class Window {
 public:
  Window(Time begin, const ReplayOptions& options) : begin_(begin), options_(options) {}
  [[nodiscard]] bool wants(Time time, std::int64_t index) const;

 private:
  Time begin_;
  ReplayOptions options_;
};

}  // namespace arpent::tools
