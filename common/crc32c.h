// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// CRC-32C (Castagnoli), the checksum of everything large that is sent or stored (RFC 3720, section B.4 has test
// vectors).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace arpent {

/// CRC-32C of `bytes`; pass the result so far as `seed` to continue over several parts. Uses the processor's
/// instruction where the build has it, a table elsewhere.
[[nodiscard]] std::uint32_t crc32c(std::span<const std::byte> bytes, std::uint32_t seed = 0);
/// The table version, for processors without the instruction (and to test against).
[[nodiscard]] std::uint32_t crc32c_portable(std::span<const std::byte> bytes, std::uint32_t seed = 0);

template <class T>
[[nodiscard]] std::uint32_t crc32c_of(std::span<const T> values, std::uint32_t seed = 0) {
  return crc32c(std::as_bytes(values), seed);
}

}  // namespace arpent
