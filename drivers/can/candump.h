// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Logs of `candump -l`, written and played back as ports.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <vector>

#include "drivers/can/can_port.h"
#include "drivers/can/reopening.h"

namespace arpent::can {

/// All frames of a log, in its order. Throws InputError, naming the line, for what is no frame; remote, error and FD
/// frames are passed over.
[[nodiscard]] std::vector<LoggedFrame> read_candump(const std::filesystem::path& file);

/// Plays a log from the moment it is opened, at its own pace; frames that are sent go nowhere.
class CandumpPort : public CanPort {
 public:
  CandumpPort(const std::filesystem::path& file, Now now);

  bool send(const CanFrame& /*frame*/) override { return true; }
  std::optional<LoggedFrame> receive() override;
  /// kGone after its last frame.
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] PortCounters counters() const override { return {}; }
  [[nodiscard]] std::string fault() const override;

 private:
  std::vector<LoggedFrame> frames_;
  std::size_t next_ = 0;
  Now now_;
  Duration offset_{0};  ///< from the log's time to the clock's
};

/// Another port, with all that passes through it written to a log: what arrives and what was taken for sending.
class RecordingPort : public CanPort {
 public:
  /// Throws InputError if the file cannot be written.
  RecordingPort(std::unique_ptr<CanPort> port, const std::filesystem::path& file, Now now);

  bool send(const CanFrame& frame) override;
  void flush() override { port_->flush(); }
  std::optional<LoggedFrame> receive() override;
  [[nodiscard]] PortState state() const override { return port_->state(); }
  [[nodiscard]] PortCounters counters() const override { return port_->counters(); }
  [[nodiscard]] std::string fault() const override { return port_->fault(); }

 private:
  void write(const LoggedFrame& frame);

  std::unique_ptr<CanPort> port_;
  std::ofstream file_;
  Now now_;
};

}  // namespace arpent::can
