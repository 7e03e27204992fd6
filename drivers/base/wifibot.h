// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// The serial protocol of Wifibot Lab robots (the thesis' own): commands out, telemetry in, in both framings that the
// firmware speaks. Little-endian, CRC-16/MODBUS. Sources: the vendor's RS232 and Ethernet documents and its published
// firmware; where they disagree, the firmware counts. Geometry and ticks vary between robots and are not known here.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace arpent::base::wifibot {

/// Largest speed that a command can carry, in the firmware's own units.
inline constexpr int kMaxSpeedTicks = 240;

/// CRC-16/MODBUS: polynomial 0xA001 reflected, from 0xFFFF.
[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> bytes);

/// Sign is direction; magnitudes are held to kMaxSpeedTicks. `closed_loop`: the board controls speeds itself.
/// `sensor_power`: relay 1, which feeds the infrared sensors.
struct SpeedCommand {
  int left_ticks = 0;
  int right_ticks = 0;
  bool closed_loop = true;
  bool sensor_power = true;
};
[[nodiscard]] std::array<std::uint8_t, 9> encode(const SpeedCommand& command);
/// The same in the 0xFE framing, where speeds are shares of full scale.
[[nodiscard]] std::array<std::uint8_t, 10> encode_stream(const SpeedCommand& command);

/// Gains in hundredths. The board zeroes its odometers on this.
struct PidCommand {
  std::uint8_t p = 80, i = 45, d = 0;
  std::uint16_t max_speed = 360;
};
[[nodiscard]] std::array<std::uint8_t, 11> encode(const PidCommand& command);

/// The watchdog of the 0xFE framing, in units of 10 ms.
[[nodiscard]] std::array<std::uint8_t, 7> encode_watchdog(std::uint16_t tens_of_ms);

/// Classic telemetry (0xFF).
struct Telemetry {
  int left_speed_ticks = 0;
  int right_speed_ticks = 0;
  double battery_v = 0;
  std::array<std::uint8_t, 4> infrared{};  ///< left front, left back, right front, right back
  std::int32_t left_odometer_ticks = 0;
  std::int32_t right_odometer_ticks = 0;
  std::uint8_t current_raw = 0;
  std::uint8_t version = 0;

  friend bool operator==(const Telemetry&, const Telemetry&) = default;
};

/// Telemetry of the 0xFE framing, with all four wheels.
struct Stream {
  std::array<std::int32_t, 4> odometers_ticks{};  ///< front left, front right, rear left, rear right
  double battery_v = 0;

  friend bool operator==(const Stream&, const Stream&) = default;
};

using Report = std::variant<Telemetry, Stream>;

/// The board's own side, for stand-ins.
[[nodiscard]] std::array<std::uint8_t, 22> encode(const Telemetry& telemetry);
[[nodiscard]] std::array<std::uint8_t, 27> encode(const Stream& stream);

/// Finds frames in a stream of bytes in any pieces. Bytes that belong to none are skipped and counted; a frame with a
/// wrong checksum costs no good one behind it.
class Parser {
 public:
  /// Over TCP and UDP the board's server leaves out the sync byte of classic telemetry: `bare`.
  explicit Parser(bool bare = false) : bare_(bare) {}

  [[nodiscard]] std::vector<Report> feed(std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::int64_t skipped_bytes() const { return skipped_; }

 private:
  bool bare_;
  std::vector<std::uint8_t> buffer_;
  std::int64_t skipped_ = 0;
};

}  // namespace arpent::base::wifibot
