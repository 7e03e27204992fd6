// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What a centre has taken and sent, as an LCM log of its own, so that a centre that is started again goes on where the
// one before ended. The log is readable at any moment, to within the last half second; it is `lcm-logplayer`'s to play.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "common/bus/bus.h"
#include "common/log/event_log.h"

namespace arpent {

class CentreJournal {
 public:
  using Reader = std::function<void(Time, const std::string& channel, BytesView)>;

  /// Gives what `file` holds to `reader`, in its order, and begins it anew with the same. Throws InputError if the file
  /// cannot be read or written.
  CentreJournal(const std::filesystem::path& file, const Reader& reader);

  void note(Time now, const std::string& channel, BytesView bytes);
  /// A message of many like it from `sender`, of which one a second will do.
  void note_sometimes(Time now, const std::string& channel, const std::string& sender, BytesView bytes);
  /// Brings to disk what was noted, at most twice a second. False once the disk has refused: the journal has ended.
  bool keep(Time now);

 private:
  std::unique_ptr<LogWriter> log_;
  std::map<std::string, Time> noted_;
  Time kept_{};
};

}  // namespace arpent
