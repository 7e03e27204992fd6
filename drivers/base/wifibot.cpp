// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/base/wifibot.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace arpent::base::wifibot {
namespace {

constexpr std::uint8_t kClassicSync = 0xFF;
constexpr std::uint8_t kStreamSync = 0xFE;
constexpr std::uint8_t kStreamCommand = 0xF1;
constexpr std::uint8_t kStreamSpeed = 0x03;
constexpr int kFullScale = 65500;
constexpr std::size_t kClassicSize = 22;  // sync, 19 bytes, checksum
constexpr std::size_t kStreamBytes = 25;  // after the size byte, checksum included
constexpr std::size_t kStreamSize = kStreamBytes + 2;

// Flags of a speed command.
constexpr std::uint8_t kLeftLoop = 0x80, kLeftForward = 0x40, kRightLoop = 0x20, kRightForward = 0x10,
                       kSensorPower = 0x01;

std::uint16_t get16(std::span<const std::uint8_t> b, std::size_t at) {
  return static_cast<std::uint16_t>(b[at] | b[at + 1] << 8);
}
std::int32_t get32(std::span<const std::uint8_t> b, std::size_t at) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(get16(b, at)) |
                                   static_cast<std::uint32_t>(get16(b, at + 2)) << 16);
}
void put16(std::span<std::uint8_t> b, std::size_t at, std::uint16_t value) {
  b[at] = static_cast<std::uint8_t>(value & 0xFF);
  b[at + 1] = static_cast<std::uint8_t>(value >> 8);
}
void put32(std::span<std::uint8_t> b, std::size_t at, std::int32_t value) {
  put16(b, at, static_cast<std::uint16_t>(static_cast<std::uint32_t>(value) & 0xFFFF));
  put16(b, at + 2, static_cast<std::uint16_t>(static_cast<std::uint32_t>(value) >> 16));
}

/// The checksum covers everything between the sync byte and itself, at the end.
void seal(std::span<std::uint8_t> frame) {
  put16(frame, frame.size() - 2, crc16(frame.subspan(1, frame.size() - 3)));
}
bool sealed(std::span<const std::uint8_t> frame) {
  return get16(frame, frame.size() - 2) == crc16(frame.subspan(1, frame.size() - 3));
}

std::uint16_t magnitude(int ticks) {
  return static_cast<std::uint16_t>(std::min(std::abs(ticks), kMaxSpeedTicks));
}

std::uint8_t flags_of(const SpeedCommand& c) {
  return static_cast<std::uint8_t>((c.closed_loop ? kLeftLoop | kRightLoop : 0) |
                                   (c.left_ticks >= 0 ? kLeftForward : 0) | (c.right_ticks >= 0 ? kRightForward : 0) |
                                   (c.sensor_power ? kSensorPower : 0));
}

Telemetry read_telemetry(std::span<const std::uint8_t> b) {
  Telemetry t;
  t.left_speed_ticks = static_cast<std::int16_t>(get16(b, 1));
  t.battery_v = b[3] / 10.0;
  t.infrared = {b[4], b[5], b[12], b[13]};
  t.left_odometer_ticks = get32(b, 6);
  t.right_speed_ticks = static_cast<std::int16_t>(get16(b, 10));
  t.right_odometer_ticks = get32(b, 14);
  t.current_raw = b[18];
  t.version = b[19];
  return t;
}

Stream read_stream(std::span<const std::uint8_t> b) {
  Stream s;
  for (std::size_t i = 0; i < 4; ++i) s.odometers_ticks[i] = get32(b, 3 + 4 * i);
  s.battery_v = b[19] / 10.0;
  return s;
}

/// Size of the frame that these bytes may begin, 0 if none can.
std::size_t frame_size(std::span<const std::uint8_t> b) {
  if (b[0] == kClassicSync) return kClassicSize;
  const bool fits =
      b[0] == kStreamSync && (b.size() < 2 || b[1] == kStreamBytes) && (b.size() < 3 || b[2] == kStreamCommand);
  return fits ? kStreamSize : 0;
}

/// What these bytes begin with: a report, a byte to skip (no report), or something that needs more bytes (0).
struct Taken {
  std::size_t bytes = 0;
  std::optional<Report> report;
};

Taken take(std::span<const std::uint8_t> b) {
  const std::size_t size = frame_size(b);
  if (size > b.size()) return {};
  if (size == 0 || !sealed(b.first(size))) return {1, std::nullopt};
  if (size == kClassicSize) return {size, read_telemetry(b)};
  return {size, read_stream(b)};
}

/// Telemetry without its sync byte.
Taken take_bare(std::span<const std::uint8_t> b) {
  constexpr std::size_t kBareSize = kClassicSize - 1;
  if (b.size() < kBareSize) return {};
  std::array<std::uint8_t, kClassicSize> frame{kClassicSync};
  std::copy_n(b.begin(), kBareSize, frame.begin() + 1);
  if (!sealed(frame)) return {1, std::nullopt};
  return {kBareSize, read_telemetry(frame)};
}

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> bytes) {
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc = static_cast<std::uint16_t>(crc ^ byte);
    for (int bit = 0; bit < 8; ++bit) {
      crc = static_cast<std::uint16_t>((crc & 1) != 0 ? (crc >> 1) ^ 0xA001 : crc >> 1);
    }
  }
  return crc;
}

std::array<std::uint8_t, 9> encode(const SpeedCommand& c) {
  std::array<std::uint8_t, 9> frame{kClassicSync, 7};
  put16(frame, 2, magnitude(c.left_ticks));
  put16(frame, 4, magnitude(c.right_ticks));
  frame[6] = flags_of(c);
  seal(frame);
  return frame;
}

std::array<std::uint8_t, 10> encode_stream(const SpeedCommand& c) {
  std::array<std::uint8_t, 10> frame{kStreamSync, 8, kStreamSpeed};
  const auto scaled = [](int ticks) {
    return static_cast<std::uint16_t>(magnitude(ticks) * kFullScale / kMaxSpeedTicks);
  };
  put16(frame, 3, scaled(c.left_ticks));
  put16(frame, 5, scaled(c.right_ticks));
  frame[7] = flags_of(c);
  seal(frame);
  return frame;
}

std::array<std::uint8_t, 11> encode(const PidCommand& c) {
  std::array<std::uint8_t, 11> frame{kClassicSync, 9, 0, 0, c.p, c.i, c.d};
  put16(frame, 7, c.max_speed);
  seal(frame);
  return frame;
}

std::array<std::uint8_t, 7> encode_watchdog(std::uint16_t tens_of_ms) {
  std::array<std::uint8_t, 7> frame{kStreamSync, 5, 4};
  put16(frame, 3, tens_of_ms);
  seal(frame);
  return frame;
}

std::array<std::uint8_t, 22> encode(const Telemetry& t) {
  std::array<std::uint8_t, kClassicSize> b{kClassicSync};
  put16(b, 1, static_cast<std::uint16_t>(t.left_speed_ticks));
  b[3] = static_cast<std::uint8_t>(std::lround(t.battery_v * 10));
  b[4] = t.infrared[0];
  b[5] = t.infrared[1];
  put32(b, 6, t.left_odometer_ticks);
  put16(b, 10, static_cast<std::uint16_t>(t.right_speed_ticks));
  b[12] = t.infrared[2];
  b[13] = t.infrared[3];
  put32(b, 14, t.right_odometer_ticks);
  b[18] = t.current_raw;
  b[19] = t.version;
  seal(b);
  return b;
}

std::array<std::uint8_t, 27> encode(const Stream& s) {
  std::array<std::uint8_t, kStreamSize> b{kStreamSync, kStreamBytes, kStreamCommand};
  for (std::size_t i = 0; i < 4; ++i) put32(b, 3 + 4 * i, s.odometers_ticks[i]);
  b[19] = static_cast<std::uint8_t>(std::lround(s.battery_v * 10));
  seal(b);
  return b;
}

std::vector<Report> Parser::feed(std::span<const std::uint8_t> bytes) {
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  std::vector<Report> reports;
  std::span<const std::uint8_t> rest(buffer_);
  while (!rest.empty()) {
    const Taken taken = bare_ ? take_bare(rest) : take(rest);
    if (taken.bytes == 0) break;  // wait for more
    if (taken.report) {
      reports.push_back(*taken.report);
    } else {
      ++skipped_;
    }
    rest = rest.subspan(taken.bytes);
  }
  buffer_.assign(rest.begin(), rest.end());
  return reports;
}

}  // namespace arpent::base::wifibot
