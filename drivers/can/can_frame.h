// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// One frame on a CAN bus, and its line in a candump log: `(1436509053.850870) can0 111#0096000000000000`.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "common/time.h"

namespace arpent::can {

inline constexpr std::size_t kMaxBytes = 8;
inline constexpr std::uint32_t kLargestStandardId = 0x7FF;
inline constexpr std::uint32_t kLargestExtendedId = 0x1FFFFFFF;

struct CanFrame {
  std::uint32_t id = 0;  ///< 11 bits, or 29 if `extended`
  bool extended = false;
  std::uint8_t size = 0;  ///< DLC, 0 .. 8
  std::array<std::uint8_t, kMaxBytes> data{};

  friend bool operator==(const CanFrame&, const CanFrame&) = default;
};

[[nodiscard]] CanFrame make_frame(std::uint32_t id, std::span<const std::uint8_t> bytes);

/// `ID#DATA` in hexadecimal: three digits for a standard identifier, eight for an extended one.
[[nodiscard]] std::string to_text(const CanFrame& frame);
/// nullopt for anything else, remote and FD frames included.
[[nodiscard]] std::optional<CanFrame> from_text(std::string_view text);

struct LoggedFrame {
  Time stamp;
  std::string interface;
  CanFrame frame;
};
[[nodiscard]] std::string to_candump_line(const LoggedFrame& logged);
[[nodiscard]] std::optional<LoggedFrame> from_candump_line(std::string_view line);

}  // namespace arpent::can
