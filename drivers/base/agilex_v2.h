// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Frames of AgileX chassis, protocol version 2 (Scout, Scout Mini, Tracer, Bunker): big-endian, 500 kbit/s. Source: the
// vendor's manuals (Scout 1.3.0, tables 3.1 to 3.14). The chassis powers up in standby and ignores motion until it is
// told to listen to CAN; without a command for half a second it stops by itself.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>

#include "common/twist2.h"
#include "drivers/can/can_frame.h"

namespace arpent::base::agilex {

inline constexpr std::uint32_t kMotionCommandId = 0x111;
inline constexpr std::uint32_t kModeCommandId = 0x421;
inline constexpr std::uint32_t kClearErrorsId = 0x441;
inline constexpr std::uint32_t kSystemStateId = 0x211;
inline constexpr std::uint32_t kMotionStateId = 0x221;
inline constexpr std::uint32_t kOdometryId = 0x311;

enum class Mode : std::uint8_t { kStandby = 0, kCan = 1, kUart = 2, kRemote = 3 };
enum class VehicleState : std::uint8_t { kNormal = 0, kEmergencyStop = 1, kException = 2 };

struct SystemState {
  VehicleState vehicle = VehicleState::kNormal;
  Mode mode = Mode::kStandby;
  double battery_v = 0;
  bool undervoltage_fault = false;
  bool undervoltage_warning = false;
  bool remote_lost = false;
  std::uint8_t count = 0;  ///< goes up with every frame: one that stands still is stale

  friend bool operator==(const SystemState&, const SystemState&) = default;
};

struct MotionState {
  Twist2 twist;
  friend bool operator==(const MotionState&, const MotionState&) = default;
};

/// Way of each side since power-up, wrapping at 32 bits.
struct Odometry {
  std::int32_t left_mm = 0;
  std::int32_t right_mm = 0;
  friend bool operator==(const Odometry&, const Odometry&) = default;
};

using Report = std::variant<SystemState, MotionState, Odometry>;

/// Rounded to 1 mm/s and 1 mrad/s; the twist must be finite and within +-32 m/s.
[[nodiscard]] can::CanFrame encode_motion(const Twist2& twist);
[[nodiscard]] can::CanFrame encode_mode(Mode mode);
[[nodiscard]] can::CanFrame encode_clear_errors();

/// nullopt for frames that are none of these, of the wrong size, or with values that cannot be.
[[nodiscard]] std::optional<Report> decode(const can::CanFrame& frame);

/// Whether it should have been one of these.
[[nodiscard]] bool is_report(const can::CanFrame& frame);

/// The chassis' own side, for stand-ins.
[[nodiscard]] can::CanFrame encode(const Report& report);
[[nodiscard]] std::optional<Twist2> decode_motion(const can::CanFrame& frame);
[[nodiscard]] std::optional<Mode> decode_mode(const can::CanFrame& frame);

}  // namespace arpent::base::agilex
