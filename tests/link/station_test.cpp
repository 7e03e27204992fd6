// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
#include "link/station.h"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <random>

#include "common/error.h"
#include "link/sent_history.h"

namespace arpent::link {
namespace {

Time at(double s) {
  return from_utime(static_cast<std::int64_t>(s * 1e6));
}

Station station(const std::string& name, std::uint32_t session = 1) {
  StationParams params;
  params.station = name;
  return {params, session};
}

Payload bytes(const std::string& text) {
  return {text.begin(), text.end()};
}

Payload ramp(std::size_t size) {
  Payload payload(size);
  std::iota(payload.begin(), payload.end(), std::uint8_t{0});
  return payload;
}

std::string only(const Taken& taken) {
  if (taken.deliveries.size() != 1) return "(" + std::to_string(taken.deliveries.size()) + " deliveries)";
  return {taken.deliveries[0].bytes.begin(), taken.deliveries[0].bytes.end()};
}

// Clocks of two machines that have nothing to do with each other: the centre's is a year ahead.
constexpr double kYearS = 365 * 86400.0;

TEST(LinkStation, ATourArrivesThoughTheClocksDisagreeByAYear) {
  Station robot = station("R1"), centre = station("centre");
  (void)centre.take(at(kYearS), robot.beat(at(10)));
  const Taken taken = robot.take(at(10.5), centre.command(Channel::kTour, bytes("tour")));
  EXPECT_EQ(only(taken), "tour");
  EXPECT_EQ(taken.refused, "");
}

TEST(LinkStation, ATourThatWasSentLongAgoIsLateByTheReceiversOwnClock) {
  Station robot = station("R1"), centre = station("centre");
  (void)centre.take(at(kYearS), robot.beat(at(10)));
  const Command tour = centre.command(Channel::kTour, bytes("tour"));
  EXPECT_EQ(only(Station(robot).take(at(13.0), tour)), "tour");  // expiry 3 s
  const Taken taken = robot.take(at(13.1), tour);
  EXPECT_TRUE(taken.deliveries.empty());
  EXPECT_EQ(taken.refused, "late");
}

TEST(LinkStation, ATourOfASenderThatHasNotHeardTheReceiverIsLate) {
  Station robot = station("R1"), centre = station("centre");
  EXPECT_EQ(robot.take(at(1), centre.command(Channel::kTour, bytes("tour"))).refused, "late");
  (void)centre.take(at(0), robot.beat(at(1)));
  const Command tour = centre.command(Channel::kTour, bytes("tour"));
  // The robot's link restarts: the echo is of a clock that is no more.
  Station restarted = station("R1", 2);
  EXPECT_EQ(restarted.take(at(1.1), tour).refused, "late");
}

TEST(LinkStation, AReportIsNeverLate) {
  Station robot = station("R1"), centre = station("centre");
  EXPECT_EQ(only(centre.take(at(1000), robot.command(Channel::kReport, bytes("visited")))), "visited");
}

TEST(LinkStation, ACommandThatComesTwiceCountsOnce) {
  Station robot = station("R1"), centre = station("centre");
  const Command report = robot.command(Channel::kReport, bytes("visited"));
  EXPECT_EQ(only(centre.take(at(1), report)), "visited");
  EXPECT_EQ(centre.take(at(2), report).refused, "repeated");
}

TEST(LinkStation, WhatIsSentAgainMayComeAfterWhatIsNewerButAnOlderTourReplacesNoNewerOne) {
  Station robot = station("R1"), centre = station("centre");
  const Command first = robot.command(Channel::kReport, bytes("first"));
  const Command second = robot.command(Channel::kReport, bytes("second"));
  EXPECT_EQ(only(centre.take(at(1), second)), "second");
  EXPECT_EQ(only(centre.take(at(1), first)), "first");
  (void)centre.take(at(1), robot.beat(at(1)));
  const Command old_tour = centre.command(Channel::kTour, bytes("old"));
  const Command new_tour = centre.command(Channel::kTour, bytes("new"));
  EXPECT_EQ(only(robot.take(at(1.1), new_tour)), "new");
  EXPECT_EQ(robot.take(at(1.2), old_tour).refused, "late");
}

TEST(LinkStation, AnOlderStateAfterANewerIsDroppedAndASessionThatIsOverToo) {
  Station old_self = station("R1", 7), listener = station("R2");
  const Beat first = old_self.state(at(50), bytes("a")), second = old_self.state(at(50.1), bytes("b"));
  EXPECT_EQ(only(listener.take(at(1), second)), "b");
  EXPECT_EQ(listener.take(at(1.1), first).refused, "stale");
  // Restarted, its clock starts anew: that is no older state.
  Station new_self = station("R1", 8);
  EXPECT_EQ(only(listener.take(at(2), new_self.state(at(0.1), bytes("c")))), "c");
  EXPECT_EQ(listener.take(at(2.1), old_self.state(at(60), bytes("d"))).refused, "stale");
}

TEST(LinkStation, AStopIsDeliveredOnceByItsEventOrByAnyBeatWhicheverComesFirst) {
  Station robot = station("R1");
  const auto event = robot.stop(bytes("stop"));
  ASSERT_TRUE(event);
  const Beat beat = robot.beat(at(1));
  for (const bool beat_first : {true, false}) {
    Station other = station("R2");
    const Taken first = beat_first ? other.take(at(1), beat) : other.take(at(1), *event);
    const Taken then = beat_first ? other.take(at(1), *event) : other.take(at(1), beat);
    ASSERT_EQ(only(first), "stop");
    EXPECT_EQ(first.deliveries[0].channel, Channel::kStop);
    EXPECT_TRUE(then.deliveries.empty());
    EXPECT_TRUE(other.take(at(1.05), robot.beat(at(1.05))).deliveries.empty());
  }
}

TEST(LinkStation, WhoComesLateIsStoppedWhileTheStopIsInForceAndNotAfterItsRelease) {
  Station robot = station("R1");
  (void)robot.stop(bytes("stop"));
  EXPECT_EQ(only(station("R3").take(at(100), robot.beat(at(1)))), "stop");
  robot.release();
  EXPECT_TRUE(station("R3").take(at(100), robot.beat(at(1))).deliveries.empty());
  // The next one is a new one for everybody.
  Station known = station("R2");
  (void)known.take(at(100), robot.beat(at(2)));
  (void)robot.stop(bytes("again"));
  EXPECT_EQ(only(known.take(at(101), robot.beat(at(3)))), "again");
}

TEST(LinkStation, AStopThatCameOverTheRadioIsNotSentBack) {
  Station first = station("R1"), second = station("R2");
  const auto event = first.stop(bytes("stop"));
  ASSERT_EQ(only(second.take(at(1), *event)), "stop");
  EXPECT_FALSE(second.stop(bytes("stop")));  // its own bus says it again
  EXPECT_FALSE(second.stopped());
  EXPECT_TRUE(second.stop(bytes("another")));
}

TEST(LinkStation, SilenceCountsFromLocalReceiptAndIsSaidOnce) {
  Station robot = station("R1"), listener = station("R2");
  (void)listener.take(at(10), robot.beat(at(kYearS)));
  auto changes = listener.changes(at(10.1));
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].station, "R1");
  EXPECT_FALSE(changes[0].silent);
  EXPECT_TRUE(listener.changes(at(11.0)).empty());
  changes = listener.changes(at(11.1));
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_TRUE(changes[0].silent);
  EXPECT_TRUE(listener.changes(at(12)).empty());
  (void)listener.take(at(13), robot.beat(at(kYearS + 3)));
  changes = listener.changes(at(13));
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_FALSE(changes[0].silent);
}

TEST(LinkStation, PatchesOfEverySizeComeOutAsTheyWentIn) {
  Station robot = station("R1"), other = station("R2");
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kPartBytes - 1, kPartBytes, kPartBytes + 1,
                                 std::size_t{10000}, kMaxParts * kPartBytes}) {
    const Payload patch = ramp(size);
    std::vector<Delivery> deliveries;
    for (const Part& part : robot.parts(patch)) {
      EXPECT_LE(part.data.size(), kPartBytes);
      for (Delivery& delivery : other.take(part).deliveries) deliveries.push_back(std::move(delivery));
    }
    ASSERT_EQ(deliveries.size(), 1U) << size;
    EXPECT_EQ(deliveries[0].bytes, patch) << size;
  }
  EXPECT_TRUE(robot.parts(ramp(kMaxParts * kPartBytes + 1)).empty());
}

TEST(LinkStation, WhatArrivesOfAPatchWithPiecesMissingOrTwiceIsNeverAWrongPatch) {
  Station robot = station("R1");
  std::vector<Part> sent;
  std::vector<Payload> patches;
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    patches.push_back(ramp(1 + random() % 30000));
    for (Part& part : robot.parts(patches.back())) sent.push_back(std::move(part));
  }
  Station other = station("R2");
  std::size_t whole = 0;
  std::vector<Payload>::iterator next = patches.begin();
  for (const Part& part : sent) {
    if (random() % 10 == 0) continue;
    for (int times = random() % 10 == 0 ? 2 : 1; times > 0; --times) {
      for (const Delivery& delivery : other.take(part).deliveries) {
        next = std::find(next, patches.end(), delivery.bytes);
        ASSERT_NE(next, patches.end());
        ++next;
        ++whole;
      }
    }
  }
  EXPECT_GT(whole, 10U);
  EXPECT_LT(whole, 50U);
}

TEST(LinkStation, APatchFromTheHistoryOfASenderThatIsKnownComesOnce) {
  Station robot = station("R1"), other = station("R2");
  const auto first = robot.parts(ramp(10)), second = robot.parts(ramp(20));
  for (const auto& patch : {first, second}) EXPECT_EQ(other.take(patch[0]).deliveries.size(), 1U);
  for (const auto& patch : {first, second}) EXPECT_EQ(other.take(patch[0]).refused, "repeated");
}

/// Seconds until `station`, asked ten times a second from `from_s` on, wants to reconnect; `limit_s` if it does not.
double reconnects_after(Station& station, double from_s, double limit_s, const std::function<void(double)>& each) {
  for (double t = from_s; t < from_s + limit_s; t += 0.1) {
    each(t);
    (void)station.changes(at(t));
    if (station.should_reconnect(at(t))) return t - from_s;
  }
  return limit_s;
}

TEST(LinkStation, AStationThatHearsNobodyReconnectsEverLessOften) {
  Station robot = station("R1");
  robot.connected(at(0));
  const double first_s = reconnects_after(robot, 0, 100, [](double) {});
  EXPECT_NEAR(first_s, 6, 0.5);
  robot.connected(at(10));
  EXPECT_NEAR(reconnects_after(robot, 10, 100, [](double) {}), 2 * first_s, 0.5);
}

TEST(LinkStation, AStationThatAnotherHearsAndThisOneDoesNotIsAReasonToReconnect) {
  Station robot = station("R1"), other = station("R2"), centre = station("centre");
  robot.connected(at(0));
  // R2 hears the centre, R1 hears only R2.
  const auto without_centre = [&](double t) {
    (void)other.take(at(t), centre.beat(at(t)));
    (void)other.changes(at(t));
    (void)robot.take(at(t), other.beat(at(t)));
  };
  EXPECT_LT(reconnects_after(robot, 0, 20, without_centre), 10);
  EXPECT_TRUE(robot.misses_somebody(at(20)));
  const auto with_centre = [&](double t) {
    without_centre(t);
    (void)robot.take(at(t), centre.beat(at(t)));
  };
  robot.connected(at(20));
  EXPECT_EQ(reconnects_after(robot, 20, 300, with_centre), 300);
  EXPECT_FALSE(robot.misses_somebody(at(320)));
}

TEST(LinkStation, AStationThatIsSilentForEverybodyIsNoReasonToReconnect) {
  Station robot = station("R1"), other = station("R2"), centre = station("centre");
  robot.connected(at(0));
  (void)robot.take(at(0), centre.beat(at(0)));
  (void)other.take(at(0), centre.beat(at(0)));
  EXPECT_EQ(reconnects_after(robot, 0, 300,
                             [&](double t) {
                               (void)other.changes(at(t));
                               (void)robot.take(at(t), other.beat(at(t)));
                             }),
            300);
}

TEST(LinkSentHistory, KeepsTheNewestPartsAndGivesCommandsOnce) {
  Station robot = station("R1");
  SentHistory history(3);
  history.add(robot.parts(ramp(10)));
  history.add(robot.parts(ramp(3 * kPartBytes)));
  const std::vector<Part> parts = history.parts();
  ASSERT_EQ(parts.size(), 3U);
  EXPECT_EQ(parts.front().sequence, 2U);
  history.add(robot.command(Channel::kReport, bytes("visited")));
  EXPECT_EQ(history.take_commands().size(), 1U);
  EXPECT_TRUE(history.take_commands().empty());
}

TEST(LinkStation, ANamesakeIsRefused) {
  Station robot = station("R1", 1), other = station("R1", 2);
  EXPECT_EQ(robot.take(at(1), other.beat(at(1))).refused, "namesake");
}

TEST(LinkStation, NamesThatDoNotFitAreRefused) {
  EXPECT_THROW(station(""), InputError);
  EXPECT_THROW(station("a name"), InputError);
  EXPECT_THROW(station(std::string(32, 'R')), InputError);
}

}  // namespace
}  // namespace arpent::link
