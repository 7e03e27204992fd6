// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/imu/iio_scan.h"

#include <gtest/gtest.h>

namespace arpent::imu {
namespace {

ScanChannel channel(const char* name, int index, const char* type) {
  const auto parsed = parse_channel_type(type);
  EXPECT_TRUE(parsed) << parsed.fault();
  return {name, index, *parsed, 0};
}

TEST(ImuScan, TypesAreReadAsTheKernelWritesThem) {
  const auto type = parse_channel_type("be:u12/16>>4");
  ASSERT_TRUE(type);
  EXPECT_TRUE(type->big_endian);
  EXPECT_FALSE(type->is_signed);
  EXPECT_EQ(type->bits, 12);
  EXPECT_EQ(type->storage_bytes, 2);
  EXPECT_EQ(type->shift, 4);
  for (const char* bad :
       {"", "le:s16", "xe:s16/16>>0", "le:s20/16>>0", "le:s16/24>>0", "le:s16/16>>8", "le:f32/32>>0"}) {
    EXPECT_FALSE(parse_channel_type(bad)) << bad;
  }
}

TEST(ImuScan, ChannelsAreAlignedToTheirOwnSizeAndTheScanToTheLargest) {
  // The kernel's usual case: three 16-bit axes, then a 64-bit timestamp at 8, 16 bytes in all.
  const ScanLayout layout = lay_out({channel("t", 3, "le:s64/64>>0"), channel("x", 0, "le:s16/16>>0"),
                                     channel("y", 1, "le:s16/16>>0"), channel("z", 2, "le:s16/16>>0")});
  EXPECT_EQ(layout.bytes, 16U);
  EXPECT_EQ(layout.channels[2].offset, 4U);
  EXPECT_EQ(layout.channels[3].offset, 8U);
  const ScanLayout mixed = lay_out({channel("a", 0, "le:s8/8>>0"), channel("b", 1, "le:s24/32>>8")});
  EXPECT_EQ(mixed.channels[1].offset, 4U);
  EXPECT_EQ(mixed.bytes, 8U);
}

TEST(ImuScan, ValuesAreSignedShiftedAndOfEitherByteOrder) {
  const std::uint8_t scan[] = {0xFE, 0xFF, 0xFF, 0xFE, 0xF4, 0x80};
  const auto value = [&](const char* type, std::size_t offset) {
    ScanChannel c = channel("c", 0, type);
    c.offset = offset;
    return raw_value(scan, c);
  };
  EXPECT_EQ(value("le:s16/16>>0", 0), -2);
  EXPECT_EQ(value("le:u16/16>>0", 0), 0xFFFE);
  EXPECT_EQ(value("be:s16/16>>0", 2), -2);
  EXPECT_EQ(value("le:s12/16>>4", 4), -0x7F1) << "0x80F4 >> 4 = 0x80F, twelve bits";
  EXPECT_EQ(value("le:u12/16>>4", 4), 0x80F);
  EXPECT_EQ(value("le:s8/8>>0", 5), -128);
}

}  // namespace
}  // namespace arpent::imu
