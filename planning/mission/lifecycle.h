// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The life of a mission, whatever it does: waiting for the start, aligning with the world, running, paused, done or
// aborted; which command is allowed when, and why it is refused.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace arpent::planning {

enum class MissionState : std::int8_t { kWaiting, kAligning, kRunning, kPaused, kDone, kAborted };
enum class MissionCommand : std::int8_t { kStart = 1, kPause = 2, kResume = 3, kAbort = 4 };

[[nodiscard]] const char* describe(MissionState state);

class Lifecycle {
 public:
  [[nodiscard]] MissionState state() const { return state_; }
  /// Why it paused or was aborted.
  [[nodiscard]] const std::string& reason() const { return reason_; }
  [[nodiscard]] bool ended() const { return state_ == MissionState::kDone || state_ == MissionState::kAborted; }

  /// A sentence if the command is refused; then nothing changes.
  [[nodiscard]] std::optional<std::string> command(MissionCommand command, const std::string& source);
  /// The world frame is known: aligning becomes running.
  void aligned();
  void finish();
  void abort(const std::string& reason);

 private:
  MissionState state_ = MissionState::kWaiting;
  MissionState paused_from_ = MissionState::kAligning;
  std::string reason_;
};

}  // namespace arpent::planning
