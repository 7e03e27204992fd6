// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "common/log/event_log.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <lcm/lcm-cpp.hpp>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>

#include "common/error.h"
#include "common/log/damage_probe.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;

class EventLogTest : public testing::Test {
 protected:
  fs::path file_ = fs::path(testing::TempDir()) /
                   (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".lcmlog");

  static std::vector<std::uint8_t> payload(int i) {
    return std::vector<std::uint8_t>(static_cast<std::size_t>(5 + 7 * (i % 4)), static_cast<std::uint8_t>(i));
  }

  void write_small(int count) const {
    LogWriter writer(file_);
    for (int i = 0; i < count; ++i)
      ASSERT_TRUE(writer.write(from_utime(1000 * i), i % 2 == 0 ? "A" : "LONGER_NAME", payload(i)));
    writer.close();
    EXPECT_EQ(writer.events_on_disk(), count);
  }
};

TEST_F(EventLogTest, LcmsOwnReaderReadsOurs) {
  write_small(20);
  lcm::LogFile theirs(file_.string(), "r");
  ASSERT_TRUE(theirs.good());
  for (int i = 0; i < 20; ++i) {
    const lcm::LogEvent* event = theirs.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->eventnum, i);
    EXPECT_EQ(event->timestamp, 1000 * i);
    EXPECT_EQ(event->channel, i % 2 == 0 ? "A" : "LONGER_NAME");
    EXPECT_EQ(std::vector<std::uint8_t>(static_cast<std::uint8_t*>(event->data),
                                        static_cast<std::uint8_t*>(event->data) + event->datalen),
              payload(i));
  }
  EXPECT_EQ(theirs.readNextEvent(), nullptr);
}

TEST_F(EventLogTest, OursReadsLcmsOwn) {
  {
    lcm::LogFile theirs(file_.string(), "w");
    std::vector<std::uint8_t> data = payload(3);
    lcm::LogEvent event{0, 77, "CH", static_cast<int>(data.size()), data.data()};
    theirs.writeEvent(&event);
  }
  LogReader reader(file_);
  const auto event = reader.next();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->channel, "CH");
  EXPECT_EQ(to_utime(event->time), 77);
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.damage().places, 0);
}

TEST_F(EventLogTest, NoDamageLosesMoreThanTwoEvents) {
  write_small(12);
  const DamageProbe probe = probe_damage(file_, file_.string() + ".damaged");
  EXPECT_GT(probe.cases, 1000);
  EXPECT_LE(probe.most_lost, 2);
  EXPECT_GE(probe.most_lost, 1) << "a flipped byte cannot go unnoticed";
}

TEST_F(EventLogTest, DamageIsReported) {
  write_small(12);
  {
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(200);
    file.write("garbage!", 8);
  }
  LogReader reader(file_);
  int events = 0;
  while (reader.next()) ++events;
  EXPECT_GE(events, 10);
}

TEST_F(EventLogTest, SeekFindsTheFirstEventNotBeforeATime) {
  write_small(12);
  LogReader reader(file_);
  reader.seek(from_utime(4500));
  EXPECT_EQ(to_utime(reader.next()->time), 5000);
  reader.seek(from_utime(0));
  EXPECT_EQ(to_utime(reader.next()->time), 0);
  reader.seek(from_utime(999999));
  EXPECT_FALSE(reader.next());
}

TEST_F(EventLogTest, AbsurdEventNumbersAreReadAndCountNothingAsMissing) {
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min(), kMost = ~kLeast;
  write_small(6);
  std::int64_t place = 0;
  for (const std::int64_t number : {kLeast, kMost, std::int64_t{-1}, kMost, std::int64_t{0}, kLeast}) {
    std::fstream file(file_, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(place * 28 + 4 + [&] {
      std::int64_t before = 0;
      for (int i = 0; i < place; ++i) before += static_cast<std::int64_t>(payload(i).size()) + (i % 2 == 0 ? 1 : 11);
      return before;
    }());
    for (int shift = 56; shift >= 0; shift -= 8) file.put(static_cast<char>(number >> shift));
    ++place;
  }
  LogReader reader(file_);
  for (int i = 0; i < 6; ++i) {
    reader.seek(from_utime(1000 * i));
    for (int k = i; k < 6; ++k) ASSERT_EQ(to_utime(reader.next()->time), 1000 * k);
    EXPECT_FALSE(reader.next());
    EXPECT_EQ(reader.damage().missing, 0);
  }
}

TEST_F(EventLogTest, AFullDiskIsReportedAndWhatIsReportedIsReadable) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  auto* handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{3'000'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &limit);
  std::int64_t reported = 0;
  {
    LogWriter writer(file_);
    const std::vector<std::uint8_t> data(100'000, 7);
    for (int i = 0; i < 100; ++i) writer.write(from_utime(i), "A", data);
    EXPECT_THROW(writer.close(), InputError);
    reported = writer.events_on_disk();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  LogReader reader(file_);
  std::int64_t readable = 0;
  while (const auto event = reader.next()) readable += event->data.size() == 100'000 ? 1 : 0;
  EXPECT_GT(reported, 0);
  EXPECT_EQ(readable, reported);
  EXPECT_EQ(reader.damage().places, 0) << "no event is left half written";
}

TEST_F(EventLogTest, WhatIsNoLogIsOneClearErrorOrEmpty) {
  EXPECT_THROW(LogReader("/no/such/log"), InputError);
  EXPECT_THROW(LogReader("/tmp"), InputError);
  std::ofstream(file_).flush();
  LogReader empty(file_);
  EXPECT_FALSE(empty.next());
}

TEST_F(EventLogTest, TheRealMaebotLogIsReadWhole) {
  const char* data = std::getenv("ARPENT_DATA");
  if (data == nullptr) GTEST_SKIP() << "ARPENT_DATA is not set";
  LogReader reader(fs::path(data) / "logs" / "maebot_convex.lcmlog");
  std::int64_t events = 0, backwards = 0;
  Time last{};
  while (const auto event = reader.next()) {
    backwards += events > 0 && event->time < last ? 1 : 0;
    last = event->time;
    ++events;
  }
  EXPECT_EQ(events, 5714);  // SOURCES.txt
  EXPECT_EQ(backwards, 17);
  EXPECT_EQ(reader.damage().places, 0);
}

}  // namespace
}  // namespace arpent
