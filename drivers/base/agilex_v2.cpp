// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/agilex_v2.h"

#include <array>
#include <cmath>

#include "common/error.h"

namespace arpent::base::agilex {
namespace {

constexpr double kPerUnit = 1000;  // mm and mrad
constexpr double kUnitsPerVolt = 10;
constexpr std::uint8_t kUndervoltageFault = 0x01, kUndervoltageWarning = 0x02, kRemoteLost = 0x04;
using Bytes = std::array<std::uint8_t, can::kMaxBytes>;

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
  for (std::size_t i = sizeof(T); i-- > 0;) {
    bytes[at + i] = static_cast<std::uint8_t>(value & 0xFF);
    if constexpr (sizeof(T) > 1) value = static_cast<T>(value >> 8);
  }
}

template <class T>
T get(const Bytes& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value = value << 8 | bytes[at + i];
  return static_cast<T>(value);
}

can::CanFrame motion_frame(std::uint32_t id, const Twist2& twist) {
  constexpr double kMost = 32;
  ARPENT_ASSERT(std::abs(twist.speed_mps) < kMost && std::abs(twist.turn_rate_radps) < kMost);
  Bytes bytes{};
  put(bytes, 0, static_cast<std::int16_t>(std::lround(twist.speed_mps * kPerUnit)));
  put(bytes, 2, static_cast<std::int16_t>(std::lround(twist.turn_rate_radps * kPerUnit)));
  return can::make_frame(id, bytes);
}

Twist2 get_twist(const Bytes& bytes) {
  return {get<std::int16_t>(bytes, 0) / kPerUnit, get<std::int16_t>(bytes, 2) / kPerUnit};
}

std::optional<Report> decode_system(const Bytes& bytes) {
  if (bytes[0] > static_cast<std::uint8_t>(VehicleState::kException) ||
      bytes[1] > static_cast<std::uint8_t>(Mode::kRemote)) {
    return std::nullopt;
  }
  SystemState state;
  state.vehicle = static_cast<VehicleState>(bytes[0]);
  state.mode = static_cast<Mode>(bytes[1]);
  state.battery_v = get<std::uint16_t>(bytes, 2) / kUnitsPerVolt;
  state.undervoltage_fault = (bytes[4] & kUndervoltageFault) != 0;
  state.undervoltage_warning = (bytes[4] & kUndervoltageWarning) != 0;
  state.remote_lost = (bytes[4] & kRemoteLost) != 0;
  state.count = bytes[7];
  return state;
}

can::CanFrame encode_system(const SystemState& state) {
  Bytes bytes{};
  bytes[0] = static_cast<std::uint8_t>(state.vehicle);
  bytes[1] = static_cast<std::uint8_t>(state.mode);
  put(bytes, 2, static_cast<std::uint16_t>(std::lround(state.battery_v * kUnitsPerVolt)));
  bytes[4] = static_cast<std::uint8_t>((state.undervoltage_fault ? kUndervoltageFault : 0) |
                                       (state.undervoltage_warning ? kUndervoltageWarning : 0) |
                                       (state.remote_lost ? kRemoteLost : 0));
  bytes[7] = state.count;
  return can::make_frame(kSystemStateId, bytes);
}

}  // namespace

can::CanFrame encode_motion(const Twist2& twist) {
  return motion_frame(kMotionCommandId, twist);
}

can::CanFrame encode_mode(Mode mode) {
  return can::make_frame(kModeCommandId, std::array{static_cast<std::uint8_t>(mode)});
}

can::CanFrame encode_clear_errors() {
  return can::make_frame(kClearErrorsId, std::array{std::uint8_t{0}});
}

std::optional<Report> decode(const can::CanFrame& frame) {
  if (frame.extended || frame.size != can::kMaxBytes) return std::nullopt;
  switch (frame.id) {
    case kSystemStateId:
      return decode_system(frame.data);
    case kMotionStateId:
      return MotionState{get_twist(frame.data)};
    case kOdometryId:
      return Odometry{get<std::int32_t>(frame.data, 0), get<std::int32_t>(frame.data, 4)};
    default:
      return std::nullopt;
  }
}

bool is_report(const can::CanFrame& frame) {
  return !frame.extended && (frame.id == kSystemStateId || frame.id == kMotionStateId || frame.id == kOdometryId);
}

can::CanFrame encode(const Report& report) {
  if (const auto* state = std::get_if<SystemState>(&report)) return encode_system(*state);
  if (const auto* motion = std::get_if<MotionState>(&report)) return motion_frame(kMotionStateId, motion->twist);
  const auto& odometry = std::get<Odometry>(report);
  Bytes bytes{};
  put(bytes, 0, odometry.left_mm);
  put(bytes, 4, odometry.right_mm);
  return can::make_frame(kOdometryId, bytes);
}

std::optional<Twist2> decode_motion(const can::CanFrame& frame) {
  if (frame.extended || frame.id != kMotionCommandId || frame.size != can::kMaxBytes) return std::nullopt;
  return get_twist(frame.data);
}

std::optional<Mode> decode_mode(const can::CanFrame& frame) {
  const bool fits = !frame.extended && frame.id == kModeCommandId && frame.size >= 1;
  if (!fits || frame.data[0] > static_cast<std::uint8_t>(Mode::kUart)) return std::nullopt;
  return static_cast<Mode>(frame.data[0]);
}

}  // namespace arpent::base::agilex
