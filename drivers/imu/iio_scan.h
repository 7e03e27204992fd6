// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// How Linux' Industrial I/O lays a sample out in its buffer (kernel documentation, driver-api/iio/buffers): channels in
// the order of their index, each aligned to its own storage size, the whole padded to its largest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/result.h"

namespace arpent::imu {

struct ChannelType {
  bool big_endian = false;
  bool is_signed = true;
  int bits = 16;          ///< that carry the value
  int storage_bytes = 2;  ///< 1, 2, 4 or 8
  int shift = 0;          ///< to the right, before the bits are taken
};

/// From the kernel's notation, e.g. "le:s12/16>>4".
[[nodiscard]] Result<ChannelType> parse_channel_type(const std::string& text);

struct ScanChannel {
  std::string name;  ///< e.g. "in_anglvel_x"
  int index = 0;
  ChannelType type;
  std::size_t offset = 0;  ///< in the scan, set by lay_out
};

struct ScanLayout {
  std::vector<ScanChannel> channels;
  std::size_t bytes = 0;
};

[[nodiscard]] ScanLayout lay_out(std::vector<ScanChannel> channels);
/// The channel's raw value in one scan of the layout.
[[nodiscard]] std::int64_t raw_value(std::span<const std::uint8_t> scan, const ScanChannel& channel);

}  // namespace arpent::imu
