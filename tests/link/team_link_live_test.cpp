// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
// team_link_process as robots run it: real processes, security on, each in a network namespace of its own, over a hub
// that loses and delays frames (never any other network). In real time, some seconds a test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <arpent/base_request_t.hpp>
#include <arpent/estop_t.hpp>
#include <arpent/map_patch_t.hpp>
#include <arpent/tour_t.hpp>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <numeric>
#include <thread>

#include "common/bus/typed.h"
#include "common/channels.h"
#include "tools/team/keys.h"
#include "tools/team/radio_lab.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;
using tools::LabStation;

constexpr int kR1 = 0, kR2 = 1, kCentre = 2, kStranger = 3;
constexpr char kSecret[] = "a text that nobody else may read";

Bytes text(const std::string& value) {
  return {value.begin(), value.end()};
}

/// A number, and enough behind it for two pieces.
Bytes numbered(int number) {
  Bytes bytes(10000, static_cast<std::uint8_t>(number));
  std::copy_n(kSecret, sizeof(kSecret), bytes.begin() + 100);
  return bytes;
}

class TeamLinkLive : public testing::Test {
 protected:
  void SetUp() override {
    if (const std::string reason = radio_network_refused(); !reason.empty()) GTEST_SKIP() << reason;
    fs::create_directories(scratch_);
    tools::make_keys({.out = scratch_ / "keys", .stations = {"R1", "R2", "centre"}});
  }
  void TearDown() override {
    lab_.reset();
    fs::remove_all(scratch_);
  }

  [[nodiscard]] std::vector<LabStation> team(const std::vector<std::string>& settings = {}) const {
    std::vector<LabStation> stations;
    for (const std::string name : {"R1", "R2", "centre"}) {
      stations.push_back({name, name == "centre" ? "centre" : "robot", scratch_ / "keys" / name, settings});
    }
    return stations;
  }

  /// Opens the stations' networks and starts the links of the first `started`.
  void open(const std::vector<LabStation>& stations, const AirParams& air, int started) {
    lab_ = std::make_unique<tools::RadioLab>(stations, air, ARPENT_BIN_DIR, scratch_, [this](int station, LcmBus& bus) {
      for (const char* channel :
           {channels::kTeamPatch, channels::kTeamState, channels::kTeamTour, channels::kTeamReport, channels::kEstop}) {
        bus.subscribe_bytes(channel, {.queue_capacity = 1000}, [this, station, channel](BytesView bytes) {
          const std::lock_guard lock(mutex_);
          heard_[{station, channel}].emplace_back(bytes.begin(), bytes.end());
        });
      }
    });
    for (int i = 0; i < started; ++i) lab_->start_link(i);
  }

  [[nodiscard]] std::vector<Bytes> heard(int station, const char* channel) {
    const std::lock_guard lock(mutex_);
    return heard_[{station, channel}];
  }
  void forget() {
    const std::lock_guard lock(mutex_);
    heard_.clear();
  }

  /// Whether it comes true in time.
  static bool within(std::chrono::milliseconds time, const std::function<bool()>& done) {
    const auto until = Steady::now() + time;
    while (!done() && Steady::now() < until) std::this_thread::sleep_for(10ms);
    return done();
  }

  /// Robots' states until R1, R2 and the centre hear each other; then nothing has been heard.
  void meet() {
    ASSERT_TRUE(within(30s, [this] {
      lab_->bus(kR1).publish_bytes(channels::kRobotState, text("hello"));
      lab_->bus(kR2).publish_bytes(channels::kRobotState, text("hello"));
      lab_->bus(kCentre).publish_bytes(channels::kTour, text("hello"));
      return !heard(kR1, channels::kTeamState).empty() && !heard(kR2, channels::kTeamState).empty() &&
             heard(kCentre, channels::kTeamState).size() > 1 && !heard(kR1, channels::kTeamTour).empty() &&
             !heard(kR2, channels::kTeamTour).empty();
    }));
    std::this_thread::sleep_for(300ms);
    forget();
  }

  fs::path scratch_ = fs::temp_directory_path() / ("arpent_team_link_" + std::to_string(getpid()));
  std::unique_ptr<tools::RadioLab> lab_;

 private:
  std::mutex mutex_;
  std::map<std::pair<int, std::string>, std::vector<Bytes>> heard_;
};

TEST_F(TeamLinkLive, APatchATourAndAReportArriveWhereTheSimulatedRadioWouldDeliverThem) {
  open(team(), {.loss = 0.02}, 3);
  meet();
  map_patch_t patch{};
  patch.source = "R1";
  patch.frame = "world";
  patch.size = 7900;
  patch.blocks.resize(7900, 42);
  tour_t tour{};
  tour.robot = "R2";
  tour.number = 5;
  publish(lab_->bus(kR1), channels::kMapPatch, patch);
  publish(lab_->bus(kCentre), channels::kTour, tour);
  lab_->bus(kR2).publish_bytes(channels::kTourReport, text("visited"));
  ASSERT_TRUE(within(3s, [this] {
    return !heard(kR2, channels::kTeamPatch).empty() && !heard(kCentre, channels::kTeamPatch).empty() &&
           !heard(kR1, channels::kTeamTour).empty() && !heard(kR2, channels::kTeamTour).empty() &&
           !heard(kCentre, channels::kTeamReport).empty();
  }));
  EXPECT_THAT(heard(kCentre, channels::kTeamPatch), ElementsAre(encode(patch)));
  EXPECT_THAT(heard(kR2, channels::kTeamPatch), ElementsAre(encode(patch)));
  EXPECT_THAT(heard(kR2, channels::kTeamTour), ElementsAre(encode(tour)));
  EXPECT_THAT(heard(kCentre, channels::kTeamReport), ElementsAre(text("visited")));
  EXPECT_THAT(heard(kR1, channels::kTeamPatch), IsEmpty());   // its own
  EXPECT_THAT(heard(kR1, channels::kTeamReport), IsEmpty());  // for the centre
}

TEST_F(TeamLinkLive, AtTwentyPercentLossEveryPatchArrivesOnceAndInOrder) {
  open(team(), {.loss = 0}, 3);
  meet();
  lab_->air().set_loss(0.2);
  std::vector<Bytes> sent;
  for (int i = 0; i < 30; ++i) {
    sent.push_back(numbered(i));
    lab_->bus(kR1).publish_bytes(channels::kMapPatch, sent.back());
    std::this_thread::sleep_for(50ms);
  }
  EXPECT_TRUE(within(5s, [&] { return heard(kR2, channels::kTeamPatch).size() >= sent.size(); }));
  EXPECT_TRUE(within(5s, [&] { return heard(kCentre, channels::kTeamPatch).size() >= sent.size(); }));
  EXPECT_EQ(heard(kR2, channels::kTeamPatch), sent);
  EXPECT_EQ(heard(kCentre, channels::kTeamPatch), sent);
}

TEST_F(TeamLinkLive, AfterACutPatchesAndReportsComeLateAndToursOfTheCutDoNot) {
  open(team({"command_expiry_s=2"}), {.loss = 0.01}, 3);
  meet();
  lab_->air().cut(kR1, true);
  lab_->bus(kCentre).publish_bytes(channels::kTour, text("old"));
  lab_->bus(kR1).publish_bytes(channels::kTourReport, text("visited"));
  for (int i = 0; i < 8; ++i) {
    lab_->bus(kR1).publish_bytes(channels::kMapPatch, numbered(i));
    lab_->bus(kR2).publish_bytes(channels::kMapPatch, numbered(100 + i));
    std::this_thread::sleep_for(500ms);
  }
  EXPECT_GE(lab_->counter(kCentre, "R1.fell_silent"), 1);
  EXPECT_THAT(heard(kR1, channels::kTeamPatch), IsEmpty());
  EXPECT_EQ(heard(kCentre, channels::kTeamPatch).size(), 8U);  // R2's: who is cut off holds up nobody
  const std::int64_t late_before = lab_->counter(kR1, "radio_command.late");
  lab_->air().cut(kR1, false);
  EXPECT_TRUE(within(3s, [this] {
    return heard(kR1, channels::kTeamPatch).size() == 8 && heard(kCentre, channels::kTeamPatch).size() == 16 &&
           heard(kCentre, channels::kTeamReport).size() == 1;
  }));
  lab_->bus(kCentre).publish_bytes(channels::kTour, text("new"));
  EXPECT_TRUE(within(2s, [this] { return !heard(kR1, channels::kTeamTour).empty(); }));
  EXPECT_THAT(heard(kR1, channels::kTeamTour), ElementsAre(text("new")));
  EXPECT_TRUE(within(2s, [this] {  // states are best effort: the next one comes
    lab_->bus(kR2).publish_bytes(channels::kRobotState, text("fresh"));
    return !heard(kR1, channels::kTeamState).empty();
  }));
  EXPECT_THAT(heard(kR1, channels::kTeamState), Each(text("fresh")));
  EXPECT_TRUE(within(2s, [&] { return lab_->counter(kR1, "radio_command.late") == late_before + 1; }));
}

TEST_F(TeamLinkLive, AStopReachesEverybodyOnceAndWhoComesLateUntilItIsReleased) {
  open(team(), {.loss = 0.05}, 2);
  ASSERT_TRUE(within(30s, [this] {
    lab_->bus(kR1).publish_bytes(channels::kRobotState, text("hello"));
    return !heard(kR2, channels::kTeamState).empty();
  }));
  estop_t stop{};
  stop.source = "R1";
  lab_->air().set_loss(0.2);
  publish(lab_->bus(kR1), channels::kEstop, stop);
  EXPECT_TRUE(within(1s, [this] { return !heard(kR2, channels::kEstop).empty(); }));
  lab_->air().set_loss(0.05);  // how long joining takes on a worse radio is for bench `link`
  lab_->start_link(kCentre);
  EXPECT_TRUE(within(30s, [this] { return !heard(kCentre, channels::kEstop).empty(); }));
  std::this_thread::sleep_for(500ms);
  for (const int station : {kR1, kR2, kCentre}) {
    EXPECT_THAT(heard(station, channels::kEstop), ElementsAre(encode(stop))) << station;
  }
  base_request_t release{};
  release.action = base_request_t::ACTION_RELEASE;
  publish(lab_->bus(kR1), channels::kBaseRequest, release);
  std::this_thread::sleep_for(300ms);
  lab_->kill_link(kCentre);
  lab_->start_link(kCentre);
  EXPECT_TRUE(within(30s, [this] {
    lab_->bus(kR1).publish_bytes(channels::kRobotState, text("later"));
    return !heard(kCentre, channels::kTeamState).empty() &&
           heard(kCentre, channels::kTeamState).back() == text("later");
  }));
  EXPECT_EQ(heard(kCentre, channels::kEstop).size(), 1U);
}

TEST_F(TeamLinkLive, ALinkThatWasKilledGetsWhatItMissed) {
  open(team(), {.loss = 0.01}, 3);
  meet();
  lab_->kill_link(kR2);
  std::vector<Bytes> sent;
  for (int i = 0; i < 5; ++i) {
    sent.push_back(numbered(i));
    lab_->bus(kR1).publish_bytes(channels::kMapPatch, sent.back());
  }
  EXPECT_TRUE(within(5s, [this] { return heard(kCentre, channels::kTeamPatch).size() == 5; }));
  lab_->start_link(kR2);
  EXPECT_TRUE(within(30s, [this] { return heard(kR2, channels::kTeamPatch).size() == 5; }));
  EXPECT_EQ(heard(kR2, channels::kTeamPatch), sent);
}

TEST_F(TeamLinkLive, StrangersGetNothingGiveNothingAndReadNothingOnTheAir) {
  tools::make_keys({.out = scratch_ / "others", .stations = {"R3"}});
  for (const fs::path& keys : {fs::path(), scratch_ / "others" / "R3"}) {
    std::vector<LabStation> stations = team();
    stations.push_back({"R3", "robot", keys});
    open(stations, {.loss = 0}, 4);
    std::atomic<int> readable = 0, frames = 0;
    lab_->air().watch([&](int station, std::span<const std::uint8_t> frame) {
      if (station == kStranger) return;
      ++frames;
      const std::string_view view(reinterpret_cast<const char*>(frame.data()), frame.size());
      if (view.find(kSecret) != std::string_view::npos) ++readable;
    });
    meet();
    for (int i = 0; i < 20; ++i) {
      lab_->bus(kStranger).publish_bytes(channels::kRobotState, text("forged"));
      lab_->bus(kStranger).publish_bytes(channels::kMapPatch, text("forged"));
      lab_->bus(kStranger).publish_bytes(channels::kEstop, text("forged"));
      lab_->bus(kR1).publish_bytes(channels::kMapPatch, numbered(i));
      std::this_thread::sleep_for(50ms);
    }
    EXPECT_TRUE(within(3s, [this] { return heard(kR2, channels::kTeamPatch).size() == 20; }));
    for (const int station : {kR1, kR2, kCentre}) {
      EXPECT_THAT(heard(station, channels::kEstop), IsEmpty());
      EXPECT_THAT(heard(station, channels::kTeamState), IsEmpty());
    }
    EXPECT_THAT(heard(kStranger, channels::kTeamPatch), IsEmpty());
    EXPECT_THAT(heard(kStranger, channels::kTeamState), IsEmpty());
    EXPECT_EQ(readable, 0) << "of " << frames;
    EXPECT_GT(frames, 100);
    lab_.reset();
  }
}

TEST_F(TeamLinkLive, WithoutSecurityTheAirCanBeReadWhichShowsThatTheTestAboveLooks) {
  std::vector<LabStation> stations = team();
  for (LabStation& station : stations) station.keys.clear();
  open(stations, {.loss = 0}, 3);
  std::atomic<bool> readable = false;
  lab_->air().watch([&](int, std::span<const std::uint8_t> frame) {
    const std::string_view view(reinterpret_cast<const char*>(frame.data()), frame.size());
    if (view.find(kSecret) != std::string_view::npos) readable = true;
  });
  meet();
  lab_->bus(kR1).publish_bytes(channels::kMapPatch, numbered(1));
  EXPECT_TRUE(within(3s, [&] { return readable.load(); }));
}

TEST_F(TeamLinkLive, UnicastToNamedPeersCarriesTheSame) {
  open(team({"link.peers=10.77.0.1,10.77.0.2,10.77.0.3"}), {.loss = 0.05}, 3);
  std::atomic<int> multicast = 0;
  lab_->air().watch([&](int, std::span<const std::uint8_t> frame) {
    if (frame[0] == 0x01 && frame.size() > 200) ++multicast;
  });
  meet();
  for (int i = 0; i < 5; ++i) lab_->bus(kR1).publish_bytes(channels::kMapPatch, numbered(i));
  EXPECT_TRUE(within(5s, [this] {
    return heard(kR2, channels::kTeamPatch).size() == 5 && heard(kCentre, channels::kTeamPatch).size() == 5;
  }));
  EXPECT_EQ(multicast, 0);
}

}  // namespace
}  // namespace arpent
