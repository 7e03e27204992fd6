// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_scan.h"

#include <algorithm>
#include <cstdio>

#include "common/error.h"

namespace arpent::imu {

Result<ChannelType> parse_channel_type(const std::string& text) {
  char endian = 0;
  char sign = 0;
  int bits = 0;
  int storage_bits = 0;
  int shift = 0;
  const int read = std::sscanf(text.c_str(), "%ce:%c%d/%d>>%d", &endian, &sign, &bits, &storage_bits, &shift);
  const bool sizes = storage_bits == 8 || storage_bits == 16 || storage_bits == 32 || storage_bits == 64;
  if (read < 4 || (endian != 'l' && endian != 'b') || (sign != 's' && sign != 'u') || !sizes || bits < 1 || shift < 0 ||
      bits + shift > storage_bits) {
    return Fault{"'" + text + "' is no channel type that we understand"};
  }
  return ChannelType{endian == 'b', sign == 's', bits, storage_bits / 8, shift};
}

ScanLayout lay_out(std::vector<ScanChannel> channels) {
  std::sort(channels.begin(), channels.end(), [](const auto& a, const auto& b) { return a.index < b.index; });
  std::size_t end = 0;
  std::size_t largest = 1;
  const auto aligned = [](std::size_t at, std::size_t to) { return (at + to - 1) / to * to; };
  for (ScanChannel& channel : channels) {
    const auto size = static_cast<std::size_t>(channel.type.storage_bytes);
    channel.offset = aligned(end, size);
    end = channel.offset + size;
    largest = std::max(largest, size);
  }
  return {std::move(channels), aligned(end, largest)};
}

std::int64_t raw_value(std::span<const std::uint8_t> scan, const ScanChannel& channel) {
  const auto size = static_cast<std::size_t>(channel.type.storage_bytes);
  ARPENT_ASSERT(channel.offset + size <= scan.size());
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t byte = channel.type.big_endian ? i : size - 1 - i;
    word = word << 8 | scan[channel.offset + byte];
  }
  const int unused = 64 - channel.type.bits;
  const std::uint64_t at_top = (word >> channel.type.shift) << unused;
  return channel.type.is_signed ? static_cast<std::int64_t>(at_top) >> unused
                                : static_cast<std::int64_t>(at_top >> unused);
}

}  // namespace arpent::imu
