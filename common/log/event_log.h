// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// LCM event logs: read in spite of damage, written so that what is reported as written is on disk. The format is LCM's
// own, so lcm-logger and lcm-logplayer understand ours and we theirs. An event: sync word 0xEDA1DA01, number, time
// [us], channel length, data length (big-endian), channel, data.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/time.h"

namespace arpent {

struct LogEvent {
  std::int64_t number = 0;
  Time time;
  std::string channel;
  std::span<const std::uint8_t> data;  ///< valid as long as the reader
};

struct LogDamage {
  std::int64_t places = 0;   ///< where the log had to be searched for the next event
  std::int64_t bytes = 0;    ///< passed over
  std::int64_t missing = 0;  ///< events whose numbers are missing between two that were read
};

class LogReader {
 public:
  /// Throws InputError if the file cannot be read.
  explicit LogReader(const std::filesystem::path& file);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  /// The next intact event; nullopt at the end. An event counts as intact if its lengths make sense and another event,
  /// or the end of the file, follows it.
  [[nodiscard]] std::optional<LogEvent> next();
  /// Goes to the first event, in the order of the file, whose time is not before `time`.
  void seek(Time time);
  void rewind();
  /// What was lost in all that was read so far.
  [[nodiscard]] const LogDamage& damage() const { return damage_; }
  [[nodiscard]] std::uint64_t size_bytes() const { return size_; }
  [[nodiscard]] std::uint64_t position_bytes() const { return at_; }

 private:
  [[nodiscard]] std::optional<LogEvent> event_at(std::uint64_t at, std::uint64_t& end) const;
  [[nodiscard]] bool swallows_another(const LogEvent& event, std::uint64_t at, std::uint64_t end) const;

  const std::uint8_t* bytes_ = nullptr;
  std::uint64_t size_ = 0;
  std::uint64_t at_ = 0;
  std::int64_t last_number_ = -1;
  LogDamage damage_;
};

class LogWriter {
 public:
  /// Throws InputError if the file cannot be created.
  explicit LogWriter(const std::filesystem::path& file);
  /// Writes what is buffered; errors are lost, so call close() to know.
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Appends an event; it may wait in memory. False once the disk has refused.
  bool write(Time time, const std::string& channel, std::span<const std::uint8_t> data);
  /// Brings everything to disk (fsync). False if the disk refused; whole events before that remain readable.
  bool flush();
  /// flush() and close. Throws InputError if anything that was handed over is not on disk.
  void close();
  /// Events that are certainly on disk, readable.
  [[nodiscard]] std::int64_t events_on_disk() const { return on_disk_; }

 private:
  bool drain();

  std::filesystem::path file_;
  int fd_ = -1;
  std::vector<std::uint8_t> buffer_;
  std::vector<std::uint64_t> ends_;  ///< file position after each event that is not yet known to be on disk
  std::uint64_t position_ = 0;       ///< bytes handed to the disk
  std::uint64_t length_ = 0;         ///< bytes of all events handed over
  std::int64_t next_number_ = 0;
  std::int64_t on_disk_ = 0;
  std::string fault_;
};

}  // namespace arpent
