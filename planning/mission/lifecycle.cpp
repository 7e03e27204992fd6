// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "planning/mission/lifecycle.h"

namespace arpent::planning {

const char* describe(MissionState state) {
  switch (state) {
    case MissionState::kWaiting:
      return "waiting";
    case MissionState::kAligning:
      return "aligning";
    case MissionState::kRunning:
      return "running";
    case MissionState::kPaused:
      return "paused";
    case MissionState::kDone:
      return "done";
    case MissionState::kAborted:
      return "aborted";
  }
  return "";
}

std::optional<std::string> Lifecycle::command(MissionCommand command, const std::string& source) {
  const auto refuse = [&](const char* what) { return std::string(what) + ": the mission is " + describe(state_); };
  switch (command) {
    case MissionCommand::kStart:
      if (state_ != MissionState::kWaiting) return refuse("cannot start");
      state_ = MissionState::kAligning;
      return std::nullopt;
    case MissionCommand::kPause:
      if (state_ != MissionState::kAligning && state_ != MissionState::kRunning) return refuse("cannot pause");
      paused_from_ = state_;
      state_ = MissionState::kPaused;
      reason_ = "paused by " + source;
      return std::nullopt;
    case MissionCommand::kResume:
      if (state_ != MissionState::kPaused) return refuse("cannot resume");
      state_ = paused_from_;
      reason_.clear();
      return std::nullopt;
    case MissionCommand::kAbort:
      if (ended()) return refuse("cannot abort");
      abort("aborted by " + source);
      return std::nullopt;
  }
  return "unknown command";
}

void Lifecycle::aligned() {
  if (state_ == MissionState::kAligning) state_ = MissionState::kRunning;
}

void Lifecycle::finish() {
  if (!ended()) state_ = MissionState::kDone;
}

void Lifecycle::abort(const std::string& reason) {
  if (ended()) return;
  state_ = MissionState::kAborted;
  reason_ = reason;
}

}  // namespace arpent::planning
