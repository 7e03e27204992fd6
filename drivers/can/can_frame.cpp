// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/can/can_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "common/error.h"

namespace arpent::can {
namespace {

constexpr std::size_t kStandardDigits = 3;
constexpr std::size_t kExtendedDigits = 8;

template <class T>
std::optional<T> parse(std::string_view text, int base) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return value;
}

}  // namespace

CanFrame make_frame(std::uint32_t id, std::span<const std::uint8_t> bytes) {
  ARPENT_ASSERT(bytes.size() <= kMaxBytes && id <= kLargestStandardId);
  CanFrame frame;
  frame.id = id;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

std::string to_text(const CanFrame& frame) {
  std::string text = frame.extended ? fmt::format("{:08X}#", frame.id) : fmt::format("{:03X}#", frame.id);
  for (std::size_t i = 0; i < frame.size; ++i) text += fmt::format("{:02X}", frame.data[i]);
  return text;
}

std::optional<CanFrame> from_text(std::string_view text) {
  const std::size_t mark = text.find('#');
  if (mark != kStandardDigits && mark != kExtendedDigits) return std::nullopt;
  const auto id = parse<std::uint32_t>(text.substr(0, mark), 16);
  const std::string_view bytes = text.substr(mark + 1);
  CanFrame frame;
  frame.extended = mark == kExtendedDigits;
  if (!id || *id > (frame.extended ? kLargestExtendedId : kLargestStandardId)) return std::nullopt;
  if (bytes.size() % 2 != 0 || bytes.size() > 2 * kMaxBytes) return std::nullopt;
  frame.id = *id;
  frame.size = static_cast<std::uint8_t>(bytes.size() / 2);
  for (std::size_t i = 0; i < frame.size; ++i) {
    const auto byte = parse<std::uint8_t>(bytes.substr(2 * i, 2), 16);
    if (!byte) return std::nullopt;
    frame.data[i] = *byte;
  }
  return frame;
}

std::string to_candump_line(const LoggedFrame& logged) {
  constexpr std::int64_t kPerSecond = 1000000;
  const std::int64_t utime = to_utime(logged.stamp);
  return fmt::format("({}.{:06}) {} {}", utime / kPerSecond, utime % kPerSecond, logged.interface,
                     to_text(logged.frame));
}

std::optional<LoggedFrame> from_candump_line(std::string_view line) {
  constexpr std::size_t kFractionDigits = 6;
  const std::size_t point = line.find('.'), end = line.find(") "), space = line.find(' ', end + 2);
  if (line.empty() || line.front() != '(' || point == std::string_view::npos || end == std::string_view::npos ||
      space == std::string_view::npos || end != point + 1 + kFractionDigits) {
    return std::nullopt;
  }
  const auto seconds = parse<std::int64_t>(line.substr(1, point - 1), 10);
  const auto micros = parse<std::int64_t>(line.substr(point + 1, kFractionDigits), 10);
  const auto frame = from_text(line.substr(space + 1));
  constexpr std::int64_t kLatest = 100000000000;  // beyond any clock, far from overflow
  if (!seconds || !micros || !frame || *seconds < 0 || *seconds > kLatest || *micros < 0) return std::nullopt;
  return LoggedFrame{from_utime(*seconds * 1000000 + *micros), std::string(line.substr(end + 2, space - end - 2)),
                     *frame};
}

}  // namespace arpent::can
