// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/wire_schema.h"

#include <gtest/gtest.h>

#include <arpent/health_t.hpp>
#include <arpent/odometry_t.hpp>
#include <arpent/stereo_images_t.hpp>
#include <opencv2/core.hpp>

#include "common/bus/typed.h"
#include "common/error.h"
#include "common/image_codec.h"

namespace arpent {
namespace {

health_t small_health() {
  health_t health{};
  health.utime = 1234567890123;
  health.process = "p";
  health.message = "all is well";
  health.counters.resize(2);
  health.counters[0].name = "A.received";
  health.counters[1].value = -5;
  health.counter_count = 2;
  return health;
}

stereo_images_t small_pair() {
  stereo_images_t pair{};
  pair.left = encode_image(cv::Mat1b(3, 4, std::uint8_t{7}));
  pair.right = encode_image(cv::Mat1b(3, 4, std::uint8_t{9}), Compression::kPng);
  return pair;
}

template <class Message>
bool decodes(const Bytes& bytes) {
  Message message;
  return message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) >= 0;
}

/// What the guard lets through must be safe for the generated decoder, and what was encoded must get through.
template <class Message>
void survive_damage(const Message& message) {
  const Bytes whole = encode(message);
  const char* type = Message::getTypeName();
  EXPECT_EQ(wire_schema().check(type, whole), std::nullopt);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(wire_schema().check(type, BytesView(whole).first(size)), std::nullopt) << "cut to " << size;
  }
  int passed = 0;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      Bytes flipped = whole;
      flipped[at] = static_cast<std::uint8_t>(flipped[at] ^ (1 << bit));
      if (wire_schema().check(type, flipped)) continue;
      ++passed;
      EXPECT_TRUE(decodes<Message>(flipped)) << "byte " << at << " bit " << bit;
    }
  }
  EXPECT_GT(passed, 0) << "flips of plain numbers are not the guard's business";
  Bytes longer = whole;
  longer.push_back(0);
  EXPECT_NE(wire_schema().check(type, longer), std::nullopt);
}

TEST(WireSchema, WhatPassesTheGuardIsSafeToDecode) {
  survive_damage(small_health());
  survive_damage(small_pair());
  survive_damage(odometry_t{});
}

TEST(WireSchema, NegativeAndHugeCountsAreRefused) {
  for (const std::int32_t count : {-1, -2147483647, 3, 2147483647}) {
    health_t health = small_health();
    Bytes bytes = encode(health);
    // The count stands before the counters, whose encoding is 4 + 10 + 1 + 8 and 4 + 1 + 8 bytes.
    const std::size_t at = bytes.size() - 4 - 23 - 13;
    for (int i = 0; i < 4; ++i)
      bytes[at + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(count >> (24 - 8 * i));
    EXPECT_NE(wire_schema().check("health_t", bytes), std::nullopt) << count;
  }
}

TEST(WireSchema, NamesTheTypeOfAMessage) {
  EXPECT_EQ(wire_schema().type_of(encode(small_health())), "health_t");
  EXPECT_EQ(wire_schema().type_of(Bytes(8, 0)), "");
  EXPECT_EQ(wire_schema().type_of(Bytes(3, 0)), "");
}

TEST(WireSchema, AnotherTypeIsRefusedByItsFingerprint) {
  const auto fault = wire_schema().check("odometry_t", encode(small_health()));
  ASSERT_TRUE(fault);
  EXPECT_NE(fault->find("fingerprint"), std::string::npos);
}

TEST(WireSchema, AnUnreadableDefinitionIsOneClearError) {
  EXPECT_THROW(WireSchema("struct a { int32_t n }"), InputError);
  EXPECT_THROW(WireSchema("struct a { unknown_t n; }"), InputError);
  EXPECT_THROW(WireSchema("strict a { }"), InputError);
}

}  // namespace
}  // namespace arpent
