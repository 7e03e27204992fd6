// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wifibot_chassis.h"

#include <cmath>

#include "drivers/base/wifibot.h"

namespace arpent::base {
namespace {

constexpr std::uint8_t kClassicSync = 0xFF, kStreamSync = 0xFE;
constexpr std::uint8_t kSpeedSize = 7, kPidSize = 9, kStreamSpeedSize = 8, kWatchdogSize = 5;
constexpr std::uint8_t kStreamSpeed = 0x03, kWatchdog = 0x04;
constexpr std::uint8_t kLeftForward = 0x40, kRightForward = 0x10;
constexpr int kFullScale = 65500;
constexpr Duration kWatchdogUnit{10000};

int get16(std::span<const std::uint8_t> b, std::size_t at) {
  return b[at] | b[at + 1] << 8;
}

bool sealed(std::span<const std::uint8_t> frame) {
  return get16(frame, frame.size() - 2) == wifibot::crc16(frame.subspan(1, frame.size() - 3));
}

/// Sizes that may stand behind a sync byte; what else stands there makes it no sync byte.
bool is_size(std::uint8_t sync, std::uint8_t size) {
  if (sync == kClassicSync) return size == kSpeedSize || size == kPidSize;
  return sync == kStreamSync && (size == kStreamSpeedSize || size == kWatchdogSize);
}

int from_scale(int scaled) {
  return static_cast<int>(std::lround(static_cast<double>(scaled) * wifibot::kMaxSpeedTicks / kFullScale));
}

}  // namespace

int WifibotChassis::receive(std::span<const std::uint8_t> bytes, Time now) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  int commands = 0;
  std::span<const std::uint8_t> rest(buffer_);
  while (!rest.empty()) {
    const std::size_t taken = take(rest, now, commands);
    if (taken == 0) break;
    rest = rest.subspan(taken);
  }
  buffer_.assign(rest.begin(), rest.end());
  return commands;
}

std::size_t WifibotChassis::take(std::span<const std::uint8_t> b, Time now, int& commands) {
  const std::uint8_t sync = b[0];
  if (sync == kClassicSync) classic_ = true;
  if (sync != kClassicSync && sync != kStreamSync) return 1;
  if (b.size() < 2) return 0;
  if (!is_size(sync, b[1])) return 1;
  const std::size_t size = b[1] + 2U;
  if (b.size() < size) return 0;
  if (!sealed(b.first(size))) return 1;
  apply(b.first(size), now);
  ++commands;
  return size;
}

void WifibotChassis::apply(std::span<const std::uint8_t> frame, Time now) {
  const std::uint8_t size = frame[1];
  if (frame[0] == kClassicSync && size == kSpeedSize) {
    drive(frame[6], get16(frame, 2), get16(frame, 4), now);
  } else if (frame[0] == kClassicSync) {
    motors_.set_count(Side::kLeft, 0);
    motors_.set_count(Side::kRight, 0);
  } else if (size == kStreamSpeedSize && frame[2] == kStreamSpeed) {
    drive(frame[7], from_scale(get16(frame, 3)), from_scale(get16(frame, 5)), now);
  } else if (size == kWatchdogSize && frame[2] == kWatchdog) {
    watchdog_ = get16(frame, 3) * kWatchdogUnit;
  }
}

void WifibotChassis::drive(std::uint8_t flags, int left_ticks, int right_ticks, Time now) {
  left_ticks_ = (flags & kLeftForward) != 0 ? left_ticks : -left_ticks;
  right_ticks_ = (flags & kRightForward) != 0 ? right_ticks : -right_ticks;
  commanded_at_ = now;
}

void WifibotChassis::step(Time now, double duration_s) {
  const bool driven = now - commanded_at_ <= watchdog_;
  const double unit_mps = driven ? 1 / params_.command_ticks_per_mps : 0;
  motors_.step(left_ticks_ * unit_mps, right_ticks_ * unit_mps, duration_s);
}

std::vector<std::uint8_t> WifibotChassis::telemetry() const {
  const auto left = motors_.count(Side::kLeft), right = motors_.count(Side::kRight);
  if (!classic_) {
    const auto frame = wifibot::encode(wifibot::Stream{{left, right, left, right}, params_.battery_v});
    return {frame.begin(), frame.end()};
  }
  wifibot::Telemetry telemetry;
  telemetry.left_odometer_ticks = left;
  telemetry.right_odometer_ticks = right;
  telemetry.battery_v = params_.battery_v;
  const auto ticks = [&](Side side) {
    return static_cast<int>(std::lround(motors_.speed_mps(side) * params_.command_ticks_per_mps));
  };
  telemetry.left_speed_ticks = ticks(Side::kLeft);
  telemetry.right_speed_ticks = ticks(Side::kRight);
  const auto frame = wifibot::encode(telemetry);
  return {frame.begin(), frame.end()};
}

}  // namespace arpent::base
