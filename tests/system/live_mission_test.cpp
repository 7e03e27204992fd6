// SPDX-FileCopyrightText: The arpent authors
// SPDX-License-Identifier: BSD-3-Clause
//
// `arpent mission --live` as a user starts it: separate processes on a bus of their own, in real time. Ctrl-C and the
// mission's own limit both end it in order: exit code, log, report, a robot that is disarmed and stands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>

#include "common/bus/lcm_bus.h"
#include "common/bus/typed.h"
#include "common/channels.h"
#include "common/error.h"
#include "common/log/event_log.h"
#include "common/net/private_network.h"
#include "drivers/base/wire.h"
#include "tests/system/live_program.h"

namespace arpent {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::HasSubstr;

/// Raw pairs of 640x512 come to 0.66 MB each: a dozen of them.
constexpr std::uintmax_t kPairsFlowBytes = 8'000'000;

class LiveMission : public testing::Test {
 protected:
  void SetUp() override {
    (void)enter_private_network();
    try {
      const LcmBus bus("udpm://239.255.76.67:" + std::to_string(private_port()) + "?ttl=0");
    } catch (const InputError& error) {
      GTEST_SKIP() << "no multicast here: " << error.what();
    }
    fs::create_directories(out_);
  }
  ~LiveMission() override {
    mission_.end();
    fs::remove_all(out_);
  }
  void start(const std::vector<std::string>& arguments) {
    std::vector<std::string> words{ARPENT_BIN_DIR "/arpent-mission", ARPENT_SOURCE_DIR "/config/missions/square.yaml",
                                   "--live", "--out", out_.string()};
    words.insert(words.end(), arguments.begin(), arguments.end());
    mission_.start(words);
  }
  bool pairs_flow() const {
    std::error_code none_yet;
    const std::uintmax_t size = fs::file_size(out_ / "live.lcmlog", none_yet);
    return !none_yet && size > kPairsFlowBytes;
  }
  /// The log is whole, and the last that the base said is that it is disarmed and told to stand.
  void expect_log_of_a_robot_at_rest(std::int64_t least_pairs) const {
    LogReader log(out_ / "mission.lcmlog");
    std::map<std::string, std::int64_t> count;
    base::WheelState last;
    while (const auto event = log.next()) {
      ++count[event->channel];
      if (event->channel != channels::kWheelState) continue;
      wheel_state_t message;
      std::string fault;
      ASSERT_TRUE(decode_guarded(event->data, message, fault)) << fault;
      last = *base::from_wire(message);
    }
    EXPECT_EQ(log.damage().bytes, 0);
    for (const char* channel : {channels::kConfig, channels::kWheelState, channels::kImu, channels::kTruthPose,
                                channels::kMissionState, channels::kHealth, channels::kCan}) {
      EXPECT_GT(count[channel], 0) << channel;
    }
    EXPECT_GE(count[channels::kStereoImages], least_pairs);
    EXPECT_EQ(last.gate, base::GateState::kDisarmed);
    EXPECT_EQ(last.status.commanded, Twist2{});
  }

  fs::path out_ = fs::path(testing::TempDir()) /
                  (std::string("live_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  LiveProgram mission_{out_ / "said"};
};

TEST_F(LiveMission, CtrlCEndsItInOrderAtAnyMoment) {
  start({});
  ASSERT_TRUE(wait_until([this] { return pairs_flow(); }, 60s)) << mission_.said();
  mission_.interrupt();
  EXPECT_EQ(mission_.exit_code(60s), 1) << mission_.said();
  expect_log_of_a_robot_at_rest(8);
  EXPECT_GT(fs::file_size(out_ / "report.html"), 1000U);
  EXPECT_THAT(mission_.said(), HasSubstr("report"));
  EXPECT_FALSE(fs::exists(out_ / "live.lcmlog")) << "the raw log has become mission.lcmlog";
}

TEST_F(LiveMission, ItsOwnLimitEndsItDisarmed) {
  start({"--sensing", "depth", "--set", "mission.max_time_s=3"});
  EXPECT_EQ(mission_.exit_code(90s), 1) << mission_.said();
  expect_log_of_a_robot_at_rest(0);
  EXPECT_THAT(mission_.said(), HasSubstr("max_time_s"));
}

TEST_F(LiveMission, WhatCannotRunIsSaidInOneLineBeforeAnythingStarts) {
  start({"--set", "start=9"});
  EXPECT_EQ(mission_.exit_code(60s), 2);
  EXPECT_THAT(mission_.said(), HasSubstr("start 9"));
}

}  // namespace
}  // namespace arpent
