// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "sim/radio/radio.h"

#include <gtest/gtest.h>

namespace arpent::sim {
namespace {

constexpr Time kStart{std::chrono::seconds(10)};
const std::vector<std::string> kOne{"B"}, kThree{"B", "C", "D"};

RadioBytes message(std::size_t size) {
  return std::make_shared<const std::vector<std::uint8_t>>(size);
}
RadioParams without_loss() {
  RadioParams params;
  params.loss = 0;
  return params;
}

TEST(Radio, AMessageTakesItsTimeOnTheAirAndTheDelay) {
  Radio radio(without_loss(), 1);
  radio.send(kStart, "A", "X", kOne, true, message(1000));
  // (1000 + 190) bytes at 5 Mbit/s take 1.904 ms, and 20 ms delay.
  EXPECT_TRUE(radio.take(kStart + from_seconds(0.0218)).empty());
  const auto arrived = radio.take(kStart + from_seconds(0.0220));
  ASSERT_EQ(arrived.size(), 1U);
  EXPECT_EQ(arrived[0].receiver, "B");
  EXPECT_EQ(arrived[0].bytes->size(), 1000U);
}

TEST(Radio, OneSendingServesAllReceiversAndIsCountedOnce) {
  Radio radio(without_loss(), 1);
  radio.send(kStart, "A", "X", kThree, true, message(2500));
  EXPECT_EQ(radio.take(kStart + std::chrono::seconds(1)).size(), 3U);
  EXPECT_EQ(radio.bytes_by_channel().at("X"), 2500 + 3 * 190) << "three frames of at most 1100 bytes";
}

TEST(Radio, UnreliableMessagesAreLostAsOftenAsTheirFramesAre) {
  RadioParams params;
  params.loss = 0.2;
  Radio radio(params, 3);
  for (int i = 0; i < 4000; ++i) radio.send(kStart, "A", "X", kOne, false, message(1500));
  const auto arrived = radio.take(kStart + std::chrono::hours(1));
  EXPECT_NEAR(static_cast<double>(arrived.size()) / 4000, 0.8 * 0.8, 0.03) << "both frames have to get through";
}

TEST(Radio, ReliableMessagesAllArriveInOrderHoweverManyFramesAreLost) {
  RadioParams params;
  params.loss = 0.5;
  Radio radio(params, 4);
  for (std::size_t i = 0; i < 500; ++i)
    radio.send(kStart + i * std::chrono::milliseconds(5), "A", "X", kOne, true, message(i));
  const auto arrived = radio.take(kStart + std::chrono::hours(1));
  ASSERT_EQ(arrived.size(), 500U);
  for (std::size_t i = 0; i < 500; ++i) EXPECT_EQ(arrived[i].bytes->size(), i);
  std::int64_t without_repairs = 0;
  for (std::int64_t i = 0; i < 500; ++i) without_repairs += i + 190;
  // Each frame is sent 1 / (1 - loss) times on average; a repair is counted as a full frame.
  EXPECT_NEAR(static_cast<double>(radio.bytes_by_channel().at("X") - without_repairs), 500 * 1290, 0.15 * 500 * 1290);
}

TEST(Radio, TheSameSeedGivesTheSameDeliveries) {
  RadioParams params;
  params.loss = 0.3;
  Radio a(params, 7), b(params, 7);
  for (Radio* radio : {&a, &b}) {
    for (int i = 0; i < 200; ++i) radio->send(kStart, "A", "X", kThree, i % 2 == 0, message(800));
  }
  const auto from_a = a.take(kStart + std::chrono::hours(1)), from_b = b.take(kStart + std::chrono::hours(1));
  ASSERT_EQ(from_a.size(), from_b.size());
  for (std::size_t i = 0; i < from_a.size(); ++i) {
    EXPECT_EQ(from_a[i].time, from_b[i].time);
    EXPECT_EQ(from_a[i].receiver, from_b[i].receiver);
  }
}

}  // namespace
}  // namespace arpent::sim
