// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/crc32c.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

namespace arpent {
namespace {

std::span<const std::byte> bytes(const std::vector<std::uint8_t>& values) {
  return std::as_bytes(std::span(values));
}

// RFC 3720, section B.4 (the RFC prints the bytes in the order of transmission, least significant first).
TEST(Crc32c, EqualsTheExamplesOfRfc3720) {
  std::vector<std::uint8_t> ascending(32);
  std::vector<std::uint8_t> descending(32);
  for (std::uint8_t i = 0; i < 32; ++i) {
    ascending[i] = i;
    descending[i] = static_cast<std::uint8_t>(31 - i);
  }
  EXPECT_EQ(crc32c(bytes(std::vector<std::uint8_t>(32, 0x00))), 0x8A9136AAU);
  EXPECT_EQ(crc32c(bytes(std::vector<std::uint8_t>(32, 0xFF))), 0x62A8AB43U);
  EXPECT_EQ(crc32c(bytes(ascending)), 0x46DD794EU);
  EXPECT_EQ(crc32c(bytes(descending)), 0x113FDB5CU);
  EXPECT_EQ(crc32c(std::as_bytes(std::span(std::string_view("123456789")))), 0xE3069283U);
}

TEST(Crc32c, TheTableAndTheInstructionAgreeAndPartsAddUp) {
  std::mt19937 generator(5);
  for (std::size_t size = 0; size < 100; ++size) {
    std::vector<std::uint8_t> data(size);
    for (auto& byte : data) byte = static_cast<std::uint8_t>(generator());
    const auto whole = bytes(data);
    EXPECT_EQ(crc32c(whole), crc32c_portable(whole));
    const std::size_t cut = size == 0 ? 0 : generator() % size;
    EXPECT_EQ(crc32c(whole.subspan(cut), crc32c(whole.first(cut))), crc32c(whole));
  }
}

}  // namespace
}  // namespace arpent
