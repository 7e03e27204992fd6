// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Frames against vectors that were computed from the vendor's documents, and a parser that is fed anything.
#include "drivers/base/wifibot.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>

namespace arpent::base::wifibot {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes hex(std::string_view text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 3) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(std::string(text.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}
template <std::size_t N>
Bytes bytes(const std::array<std::uint8_t, N>& a) {
  return {a.begin(), a.end()};
}

const Bytes kTelemetry = hex("FF D8 FF 7D 3C 46 10 27 00 00 28 00 50 5A F0 D8 FF FF C1 10 26 0D");
const Telemetry kMeaning{-40, 40, 12.5, {0x3C, 0x46, 0x50, 0x5A}, 10000, -10000, 193, 16};

TEST(Wifibot, TheChecksumIsModbus) {
  const std::string_view text = "123456789";
  EXPECT_EQ(crc16(Bytes(text.begin(), text.end())), 0x4B37);
}

TEST(Wifibot, CommandsAreTheGoldenOnes) {
  EXPECT_EQ(bytes(encode(SpeedCommand{120, 120, false, false})), hex("FF 07 78 00 78 00 50 21 83"));
  EXPECT_EQ(bytes(encode(SpeedCommand{0, 0, true, true})), hex("FF 07 00 00 00 00 F1 C0 28"));
  EXPECT_EQ(bytes(encode(PidCommand{80, 45, 0, 360})), hex("FF 09 00 00 50 2D 00 68 01 A7 01"));
  EXPECT_EQ(bytes(encode_stream(SpeedCommand{0, 0, false, false})), hex("FE 08 03 00 00 00 00 50 92 CF"));
  EXPECT_EQ(bytes(encode_watchdog(10)), hex("FE 05 04 0A 00 47 89"));
}

TEST(Wifibot, SpeedsKeepTheirSignAndTheirLimit) {
  const auto frame = encode(SpeedCommand{-1000, 7});
  EXPECT_EQ(frame[2], 240);
  EXPECT_EQ(frame[6] & 0x40, 0) << "left backwards";
  EXPECT_EQ(frame[6] & 0x10, 0x10) << "right forwards";
  const auto full = encode_stream(SpeedCommand{240, -240});
  EXPECT_EQ(full[3] | full[4] << 8, 65500);
  EXPECT_EQ(full[5] | full[6] << 8, 65500);
}

TEST(Wifibot, TelemetryWithoutItsSyncByteIsFoundAmongRubbish) {
  Parser parser(true);
  Bytes stream = hex("01 02 FF 03");
  for (int i = 0; i < 3; ++i) stream.insert(stream.end(), kTelemetry.begin() + 1, kTelemetry.end());
  stream[4 + 21 + 5] ^= 1;  // spoils the second
  int found = 0;
  for (const std::uint8_t byte : stream) {
    for (const Report& report : parser.feed(std::span(&byte, 1))) {
      EXPECT_EQ(std::get<Telemetry>(report), kMeaning);
      ++found;
    }
  }
  EXPECT_EQ(found, 2);
  EXPECT_EQ(parser.skipped_bytes(), 4 + 21);
}

TEST(Wifibot, TelemetryIsReadAndWritten) {
  Parser parser;
  const auto reports = parser.feed(kTelemetry);
  ASSERT_EQ(reports.size(), 1U);
  EXPECT_EQ(std::get<Telemetry>(reports[0]), kMeaning);
  EXPECT_EQ(bytes(encode(kMeaning)), kTelemetry);
  EXPECT_EQ(parser.skipped_bytes(), 0);
}

/// The 0xFE stream, put together by hand.
Bytes stream_frame() {
  Bytes frame = hex("FE 19 F1 01 00 00 00 FE FF FF FF 03 00 00 00 04 00 00 00 7D 00 00 00 05 FB");
  const std::uint16_t crc = crc16(std::span(frame).subspan(1));
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
  return frame;
}

TEST(Wifibot, BothFramingsAreReadInAnyPieces) {
  Bytes all = {0x00, 0x12};
  for (const Bytes& frame : {stream_frame(), kTelemetry, stream_frame(), kTelemetry}) {
    all.insert(all.end(), frame.begin(), frame.end());
  }
  for (const std::size_t piece : {std::size_t{1}, std::size_t{3}, std::size_t{22}, all.size()}) {
    Parser parser;
    std::vector<Report> reports;
    for (std::size_t at = 0; at < all.size(); at += piece) {
      const auto more = parser.feed(std::span(all).subspan(at, std::min(piece, all.size() - at)));
      reports.insert(reports.end(), more.begin(), more.end());
    }
    ASSERT_EQ(reports.size(), 4U) << piece;
    EXPECT_EQ(std::get<Stream>(reports[0]), (Stream{{1, -2, 3, 4}, 12.5}));
    EXPECT_EQ(std::get<Telemetry>(reports[3]), kMeaning);
    EXPECT_EQ(parser.skipped_bytes(), 2);
  }
}

TEST(Wifibot, AFlippedByteCostsOneFrameAndNoOther) {
  for (std::size_t flipped = 0; flipped < kTelemetry.size(); ++flipped) {
    Bytes all = kTelemetry;
    all[flipped] ^= 0x5A;
    for (int i = 0; i < 3; ++i) all.insert(all.end(), kTelemetry.begin(), kTelemetry.end());
    // A sync byte that is not one may wait for bytes that the last frame has: give it more.
    all.insert(all.end(), 30, 0x00);
    EXPECT_EQ(Parser().feed(all).size(), 3U) << flipped;
  }
}

TEST(Wifibot, NoiseIsSurvived) {
  std::mt19937 random(1);
  Parser parser;
  for (int i = 0; i < 2000; ++i) {
    Bytes noise(random() % 60);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random() % 3 == 0 ? 0xFF : random());
    (void)parser.feed(noise);
  }
  Bytes all(30, 0x00);
  all.insert(all.end(), kTelemetry.begin(), kTelemetry.end());
  EXPECT_EQ(parser.feed(all).size(), 1U);
}

}  // namespace
}  // namespace arpent::base::wifibot
