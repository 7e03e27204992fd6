// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// What stands between a command and the wheels: arming, the dead man's switch, the latched emergency stop, the limits.
// It knows no bus and no protocol, and takes time as an argument, so the live driver, lockstep and tests run the same
// code.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "common/config/limits.h"
#include "common/time.h"
#include "common/twist2.h"

namespace arpent::base {

struct GateParams {
  MotionLimits limits = {};
  /// A command counts for this long after it was received, by the local monotonic clock.
  Duration command_lifetime{200000};
  /// A driver that has not looked for longer than this has slept (a stopped process, a machine in trouble). Receipt
  /// says nothing about the age of what waited meanwhile: for one lifetime all commands are refused.
  Duration longest_sleep{100000};
};

enum class GateState : std::int8_t { kDisarmed = 0, kArmed = 1, kStopped = 2 };

class CommandGate {
 public:
  explicit CommandGate(const GateParams& params) : params_(params) {}

  /// The driver looks: to be called many times in `longest_sleep`, before what has arrived is offered. After a sleep
  /// the last command no longer counts.
  void watch(Time now);

  /// A command that has just been received. A reason if it is refused: not finite, beyond a limit by more than
  /// rounding, not armed, non-zero since before the gate was armed, or perhaps stale after a sleep.
  [[nodiscard]] std::optional<std::string> offer(const Twist2& command, Time received);
  /// What the wheels shall do now: the last accepted command, or zero.
  [[nodiscard]] Twist2 output(Time now) const;

  /// Local acts. Arming is refused while stopped; releasing the stop needs zero commands (or none) and leaves the gate
  /// disarmed. A reason if refused.
  [[nodiscard]] std::optional<std::string> arm();
  void disarm();
  /// Anybody may stop, at any time.
  void stop() { state_ = GateState::kStopped; }
  [[nodiscard]] std::optional<std::string> release(Time now);

  [[nodiscard]] GateState state() const { return state_; }

 private:
  [[nodiscard]] bool fresh(Time now) const { return now - received_ <= params_.command_lifetime && now >= received_; }

  [[nodiscard]] bool slept(Time now) const { return watched_ && now - *watched_ > params_.longest_sleep; }

  GateParams params_;
  GateState state_ = GateState::kDisarmed;
  bool seen_zero_ = false;  ///< since arming: commands that were already flowing must pause first
  std::optional<Time> watched_;
  std::optional<Time> awake_since_;  ///< the last sleep's end
  std::optional<Twist2> accepted_;
  Time received_{};
  /// Any finite command, accepted or not.
  std::optional<Twist2> heard_;
  Time heard_at_{};
};

}  // namespace arpent::base
